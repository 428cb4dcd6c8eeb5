//! Computes where B2P2's masses and axles are along its own axes: the cheap part of the model,
//! which the guard needs at every tick.
//!
//! Axes of body 1, origin in the middle of axle 1 (the rear one): x forward to axle 2, y left, z
//! up.

use super::masses::Masses;
use super::parameters::LENGTHS;
use crate::estimate::attitude::LevelAxes;
use crate::math::{clamp, max, min, root_of_sum, sin_cos};
use crate::settings::{Setting, Settings};
use crate::stability::diagonal;
use crate::stability::support::Stance;
use crate::units::Angle;

/// Distance from the rear end of body 3 to axle 3, m ([`super::parameters::Lengths::axle_3`]).
pub const AXLE_3_FROM_BODY_3: f32 = LENGTHS.axle_3 as f32;

/// Sines of the chassis angles (3 and 8 degrees) between which a raised front ceases to stand on
/// the plane of axles 1 and 2.
const RAISED: [f32; 2] = [0.052, 0.139];
/// Cosines of the pitches (-55 and -70 degrees) between which a fall forward onto the front ceases
/// to be harmless.
const NOSE_DOWN: [f32; 2] = [0.574, 0.342];

/// Masses and lengths that do not change while the robot moves.
#[derive(Clone, Copy, Debug)]
pub struct Model {
    l1: f32,
    l2: f32,
    half_gauge: f32,
    pulley_radius: f32,
    /// Part of the centre of gravity that does not depend on chassis angle and extension, m.
    rigid_cog: [f32; 3],
    /// Part that the front adds, m: along and across its own axis at extension 0, and along it per
    /// metre of extension.
    front_along: f32,
    front_up: f32,
    front_share: f32,
}

/// Shape of the robot at one chassis angle and extension.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Centre of gravity, m.
    pub cog: [f32; 3],
    /// Middle of axle 2, m.
    pub axle_2: [f32; 3],
    /// Middle of axle 3, m.
    pub axle_3: [f32; 3],
    /// Sine and cosine of the chassis angle.
    pub theta: [f32; 2],
}

impl Shape {
    /// Sine and cosine of the angle by which a change to the shape `next` pitches the body up while
    /// the ground stays where it is. With its front below the body the robot stands on the pulleys
    /// of axles 1 and 3, so the body turns as the line between these axles turns in it. A slack
    /// belt also lets a nose between them sink in. How far is not known here: the measured attitude
    /// shows it.
    pub fn lift(&self, next: &Self) -> (f32, f32) {
        let bottom = |shape: &Self| [shape.axle_3[0], min(shape.axle_3[2], 0.0)];
        let ([x, z], [next_x, next_z]) = (bottom(self), bottom(next));
        let (across, along) = (z * next_x - x * next_z, x * next_x + z * next_z);
        let over = 1.0 / root_of_sum(across * across + along * along);
        (across * over, along * over)
    }
}

impl Model {
    /// Model with the lengths, masses and payload of the settings.
    pub fn new(settings: &Settings) -> Self {
        let Masses {
            body_1: body,
            body_2,
            body_3,
            payload,
            ..
        } = Masses::new(settings);
        let mass = body.mass + payload.mass;
        let place = [0, 1, 2]
            .map(|axis| (body.mass * body.place[axis] + payload.mass * payload.place[axis]) / mass);
        let total_mass = mass + body_2.mass + body_3.mass;
        let (l1, l2) = (
            settings.si(Setting::LengthL1),
            settings.si(Setting::LengthL2),
        );
        let (share_2, share_3) = (body_2.mass / total_mass, body_3.mass / total_mass);
        // Distance from axle 2 along the front part to body 3's centre of gravity, at extension 0.
        let third = l2 - AXLE_3_FROM_BODY_3 + body_3.place[0];
        Self {
            l1,
            l2,
            half_gauge: 0.5 * settings.si(Setting::TrackGauge),
            pulley_radius: settings.si(Setting::PulleyRadius),
            rigid_cog: [
                mass / total_mass * place[0] + (share_2 + share_3) * l1,
                mass / total_mass * place[1]
                    + share_2 * body_2.place[1]
                    + share_3 * body_3.place[1],
                mass / total_mass * place[2],
            ],
            front_along: share_2 * body_2.place[0] + share_3 * third,
            front_up: share_2 * body_2.place[2] + share_3 * body_3.place[2],
            front_share: share_3,
        }
    }

    /// Distance of axles 1 and 2, m.
    pub fn l1(&self) -> f32 {
        self.l1
    }

    /// Centre of gravity and axles at chassis angle `theta` and extension `l3` in m (sum of eq. 1
    /// of the paper's appendix).
    ///
    /// [`Self::new`] sums up what does not change while the robot moves: only the front part turns,
    /// and only body 3 slides.
    #[inline]
    pub fn shape(&self, theta: Angle, l3: f32) -> Shape {
        let (sine, cosine) = sin_cos(theta);
        let (reach, up) = (self.l2 + l3, self.front_up);
        let along = self.front_along + self.front_share * l3;
        let [x, y, z] = self.rigid_cog;
        Shape {
            cog: [
                x + along * cosine - up * sine,
                y,
                z + along * sine + up * cosine,
            ],
            axle_2: [self.l1, 0.0, 0.0],
            axle_3: [self.l1 + reach * cosine, 0.0, reach * sine],
            theta: [sine, cosine],
        }
    }

    /// Stance of the belts, as far as it is known without knowing the ground.
    ///
    /// The support ends behind on the lowest line of the rear pulleys. The robot falls backward
    /// about this line, whatever nose or floor it stands on. If it rolls, one rear pulley may
    /// be in the air. Then the rear edge is as far forward as a fall onto this pulley would narrow
    /// its margin ([`diagonal`]). In front the support ends on the
    /// pulley that reaches farthest, as far as the robot can stand on it ([`Self::front`]). The
    /// sides end where the belt may lie: at axle 2 with the front raised, at axle 3 with it
    /// lowered. A raised front is no support sideways, because on a side slope it hangs over the
    /// lower edge.
    ///
    /// Every corner is at a pulley, which carries under a slack belt as under a taut one; a run of
    /// the belt between two pulleys is no support. So slack changes the stance by the measured
    /// extension alone. Up to 50 degrees of pitch without payload, no margin moves by more than 0.8
    /// times the change of slack. Farther nose down, the end of the support jumps where the centre
    /// of gravity passes over axle 2, with a taut belt too ([`Self::front`]).
    pub fn stance(&self, shape: &Shape, axes: &LevelAxes) -> Stance {
        let under = |axle: [f32; 3], left: f32| {
            axes.lowest([axle[0], axle[1] + left, axle[2]], self.pulley_radius)
        };
        let cog = axes.of(shape.cog);
        let front = Self::front(shape, cog, axes);
        let raised = shape.axle_3[2] > shape.axle_2[2];
        let side = if raised { shape.axle_2 } else { shape.axle_3 };
        let (left, right) = (self.half_gauge, -self.half_gauge);
        let contacts = [
            under([0.0; 3], right),
            under(front, right),
            under(front, left),
            under([0.0; 3], left),
        ];
        let sides = [under(side, right), under(side, left)];
        let stance = Stance::on(contacts, cog).with_sides(sides);
        stance.with_back_moved(diagonal::loss(&stance))
    }

    /// Point of the front, in body axes, where the support ends; `cog` is in level axes.
    ///
    /// The plane that the robot stands on is that of axles 1 and 2. A raised axle 3 is in the air
    /// over it. It is a support only because a fall forward about axle 2 ends on it, and only if
    /// the body is not too steep then. The fall turns the body by the chassis angle; if the centre
    /// of gravity is in front of axle 2, it has turned it already. The end of the support moves
    /// from axle 3 to axle 2 while the pitch at the end of the fall goes from -55 to -70 degrees.
    /// With the front lowered or straight (up to 3 degrees) the robot stands on axle 3 itself.
    fn front(shape: &Shape, cog: [f32; 3], axes: &LevelAxes) -> [f32; 3] {
        let (second, third) = (axes.of(shape.axle_2), axes.of(shape.axle_3));
        if !(third[0] > second[0]) {
            return shape.axle_2;
        }
        let ((sine, cosine), [raise, straight]) = (axes.pitch(), shape.theta);
        let [sine, cosine] = if cog[0] > second[0] {
            [sine, cosine]
        } else {
            [
                sine * straight - cosine * raise,
                cosine * straight + sine * raise,
            ]
        };
        // 1 where the support reaches axle 3, 0 where it ends at axle 2.
        let part =
            |value: f32, [whole, none]: [f32; 2]| clamp((value - none) / (whole - none), 0.0, 1.0);
        let part = if sine > 0.0 {
            1.0
        } else {
            max(part(raise, RAISED), part(cosine, NOSE_DOWN))
        };
        let place = |axis: usize| {
            let (second, third) = (shape.axle_2[axis], shape.axle_3[axis]);
            // Exact at both ends.
            part * third + (1.0 - part) * second
        };
        [0, 1, 2].map(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::attitude::Attitude;
    use crate::robots::b2p2::B2p2;
    use crate::robots::body::Body;
    use crate::screw::{Geometry, SlackLaw, metres};
    use crate::sensors::BodySensors;
    use crate::stability::step_behind;

    /// Compares with the sum of the three bodies' moments in double precision, with the front part
    /// turned body by body.
    #[test]
    fn cog_is_that_of_the_three_bodies_at_any_angle_and_extension() {
        let mut settings = Settings::default();
        for (setting, value) in [
            (Setting::PayloadMass, 3_000),
            (Setting::PayloadForward, -40_000),
            (Setting::PayloadLeft, 20_000),
            (Setting::PayloadUp, 150_000),
            (Setting::BodyHeight, 35_000),
        ] {
            settings.set(setting.description().key, value).unwrap();
        }
        assert_cog(
            &settings,
            [
                (6.356_067, [0.160_894, 0.002_784, 0.035]),
                (0.897_066, [0.104_083, -0.014_127, -0.000_723]),
                (1.062_15, [0.152_68, 0.000_01, 0.000_09]),
            ],
        );
        for (setting, value) in [
            (Setting::Body1Mass, 40_000_000),
            (Setting::Body1Forward, 200_000),
            (Setting::Body1Left, -10_000),
            (Setting::Body2Mass, 2_500_000),
            (Setting::Body2Forward, 90_000),
            (Setting::Body2Left, 30_000),
            (Setting::Body2Up, 40_000),
            (Setting::Body3Mass, 400_000),
            (Setting::Body3Forward, 100_000),
            (Setting::Body3Left, 5_000),
            (Setting::Body3Up, -20_000),
        ] {
            settings.set(setting.description().key, value).unwrap();
        }
        assert_cog(
            &settings,
            [
                (40.0, [0.2, -0.01, 0.035]),
                (2.5, [0.09, 0.03, 0.04]),
                (0.4, [0.1, 0.005, -0.02]),
            ],
        );
    }

    /// Compares the centre of gravity of a robot with these settings and a payload of 3 kg at
    /// (-0.04, 0.02, 0.15) m with that of its bodies, given by mass and position forward, left and
    /// up.
    fn assert_cog(settings: &Settings, [body_1, body_2, body_3]: [(f64, [f64; 3]); 3]) {
        let model = Model::new(settings);
        for step in 0..1_000 {
            let theta = f64::from(step) * 6.2e-3 - 3.1;
            let l3 = f64::from(step % 37) * 0.01 + 0.2;
            let (sine, cosine) = (libm::sin(theta), libm::cos(theta));
            let turned = |[along, left, up]: [f64; 3], slid: f64| {
                let along = along + slid;
                [
                    0.32 + along * cosine - up * sine,
                    left,
                    along * sine + up * cosine,
                ]
            };
            let bodies = [
                body_1,
                (3.0, [-0.04, 0.02, 0.15]),
                (body_2.0, turned(body_2.1, 0.0)),
                (body_3.0, turned(body_3.1, 0.23 + l3 - 0.226)),
            ];
            let total: f64 = bodies.iter().map(|(mass, _)| mass).sum();
            let shape = model.shape(Angle::from_radians(theta as f32), l3 as f32);
            for axis in 0..3 {
                let moment: f64 = bodies.iter().map(|(mass, place)| mass * place[axis]).sum();
                let error = (f64::from(shape.cog[axis]) - moment / total).abs();
                assert!(error < 1.5e-7, "axis {axis} at {theta}, {l3}: {error:e} m");
            }
        }
    }

    #[test]
    fn straight_robot_has_its_cog_where_a_hand_calculation_has_it() {
        let model = Model::new(&Settings::default());
        let shape = model.shape(Angle::ZERO, 0.226);
        // (6.356067*0.160894 + 0.897066*(0.32+0.104083) + 1.06215*(0.32+0.456-0.226+0.15268)) /
        // 8.315283
        assert!((shape.cog[0] - 0.258_49).abs() < 1e-4, "{:?}", shape.cog);
        assert!(shape.cog[2].abs() < 1e-3);
        assert!((shape.axle_3[0] - 0.776).abs() < 1e-6);
    }

    #[test]
    fn a_payload_pulls_the_cog_towards_it() {
        let mut settings = Settings::default();
        settings
            .set(Setting::PayloadMass.description().key, 8_315)
            .unwrap();
        settings
            .set(Setting::PayloadUp.description().key, 250_000)
            .unwrap();
        let shape = Model::new(&settings).shape(Angle::ZERO, 0.226);
        assert!((shape.cog[2] - 0.125).abs() < 1e-3, "{:?}", shape.cog);
    }

    fn tilted(pitch_degrees: f64) -> Attitude {
        let mut attitude = Attitude::default();
        let reading = BodySensors {
            inclination: [pitch_degrees.to_radians() as f32, 0.0],
            ..BodySensors::default()
        };
        attitude.update(&reading, 1e-3);
        attitude
    }

    /// Payloads: mass in g, position forward and up in um. With its front lowered the robot stands
    /// on axles 1 and 3.
    #[test]
    fn what_b2p2_bears_behind_it() {
        let room = |payload: [i32; 3], slope: f64, theta: f64| {
            let mut settings = Settings::default();
            let step = B2p2::step_behind(&settings);
            for (setting, value) in [
                Setting::PayloadMass,
                Setting::PayloadForward,
                Setting::PayloadUp,
            ]
            .into_iter()
            .zip(payload)
            {
                settings.set(setting.description().key, value).unwrap();
            }
            let model = Model::new(&settings);
            let shape = model.shape(Angle::from_radians(theta.to_radians() as f32), 0.226);
            let lifted = libm::atan2(
                -f64::from(shape.axle_3[2].min(0.0)),
                f64::from(shape.axle_3[0]),
            );
            let pitch = slope + lifted.to_degrees();
            let stance = model.stance(&shape, &tilted(pitch).level_axes());
            step_behind::room(&stance, &step, 0.0)
        };
        // A room of 1 m corresponds to 4.4 m/s.
        assert!(room([0, 0, 0], 0.0, 0.0) > 1.0);
        assert!(room([0, 0, 0], 0.0, -45.0) > 0.02);
        assert!(room([0, 0, 0], 0.0, -50.0) < 0.0);
        let high = [3_600, 250_000, 270_000];
        assert!(room(high, 0.0, -10.0) > 0.01);
        assert!(room(high, 0.0, -15.0) < 0.0);
        assert!(room(high, 34.0, 0.0) > 0.05);
        assert!(room([4_000, 0, 300_000], 0.0, 0.0) < 0.0);
    }

    #[test]
    fn folding_the_front_pitches_the_body_up_by_the_turn_of_the_line_that_it_stands_on() {
        let model = Model::new(&Settings::default());
        let shape = |degrees: f64, extension: f32| {
            model.shape(Angle::from_radians(degrees.to_radians() as f32), extension)
        };
        let line = |degrees: f64, extension: f64| {
            let (length, angle) = (0.23 + extension, degrees.min(0.0).to_radians());
            let (x, z) = (libm::cos(angle) * length, libm::sin(angle) * length);
            libm::atan2(z, 0.32 + x)
        };
        for from in [-50.0, -31.6, -4.0, 0.0, 20.0] {
            for to in [-55.0, -20.0, -1.0, 0.0, 45.0] {
                let (sine, cosine) = shape(from, 0.226).lift(&shape(to, 0.24));
                let found = libm::atan2(f64::from(sine), f64::from(cosine));
                let expected = line(from, 0.226) - line(to, 0.24);
                assert!((found - expected).abs() < 1e-6, "{from} {to}: {found}");
            }
        }
    }

    /// The robot has its front straight and carries 3.06 kg. With a pitch of 59 degrees and a roll
    /// of 5, such a robot stood on one rear pulley and on a nose. It fell over the diagonal and
    /// toppled. The test compares with figures of `docs/guard.md`, from the sum of the moments.
    #[test]
    fn a_rear_pulley_that_may_be_in_the_air_narrows_the_rear_margin() {
        let mut settings = Settings::default();
        for (setting, value) in [
            (Setting::PayloadMass, 3_058),
            (Setting::PayloadForward, 172_000),
            (Setting::PayloadUp, 288_000),
        ] {
            settings.set(setting.description().key, value).unwrap();
        }
        let model = Model::new(&settings);
        let shape = model.shape(Angle::ZERO, 0.226);
        let margin = |pitch: f64, roll: f64| {
            let mut attitude = Attitude::default();
            let reading = BodySensors {
                inclination: [pitch, roll].map(|degrees| degrees.to_radians() as f32),
                ..BodySensors::default()
            };
            attitude.update(&reading, 1e-3);
            model.stance(&shape, &attitude.level_axes()).margins()[0]
        };
        for (pitch, level, rolled) in [(20.0, 0.195, 0.181), (50.0, 0.092, 0.052)] {
            assert!((margin(pitch, 0.0) - level).abs() < 1e-3);
            for roll in [-5.0, 5.0] {
                assert!((margin(pitch, roll) - rolled).abs() < 1e-3);
            }
        }
        for roll in [-20.0, 20.0] {
            // A side slope leaves the margin wide.
            assert!(margin(0.0, roll) > 0.2);
        }
    }

    fn front_margin(model: &Model, pitch: f64, theta: f64) -> f32 {
        let shape = model.shape(Angle::from_radians(theta.to_radians() as f32), 0.226);
        model.stance(&shape, &tilted(pitch).level_axes()).margins()[1]
    }

    /// Distance of the centre of gravity behind axle 2, by the sum of the moments in double
    /// precision.
    fn behind_axle_2(pitch: f64, theta: f64, (load, [x, up]): (f64, [f64; 2])) -> f64 {
        let place = |angle: f64, [along, up]: [f64; 2]| {
            let angle = angle.to_radians();
            along * libm::cos(angle) - up * libm::sin(angle)
        };
        let bodies = [
            (6.356_067, place(pitch, [0.160_894 - 0.32, 0.0])),
            (0.897_066, place(pitch + theta, [0.104_083, -0.000_723])),
            (1.062_15, place(pitch + theta, [0.23 + 0.152_68, 0.000_09])),
            (load, place(pitch, [x - 0.32, up])),
        ];
        let mass: f64 = bodies.iter().map(|(mass, _)| mass).sum();
        -bodies.iter().map(|(mass, x)| mass * x).sum::<f64>() / mass
    }

    /// On a slope of -50 degrees, the fall onto the raised front would turn the body to -95 degrees
    /// or more.
    #[test]
    fn a_front_raised_on_a_steep_descent_is_no_support() {
        let model = Model::new(&Settings::default());
        for theta in [45.0, 60.0, 75.0, 95.0] {
            let found = front_margin(&model, -50.0, theta);
            let expected = behind_axle_2(-50.0, theta, (0.0, [0.0; 2]));
            assert!(
                expected > -0.05,
                "the robot stands on axles 1 and 2: {expected}"
            );
            assert!(
                (f64::from(found) - expected).abs() < 1e-5,
                "{theta}: {found}, {expected}"
            );
        }
        // On level ground a fall onto a front at 45 degrees does no harm.
        assert!(front_margin(&model, 0.0, 45.0) > 0.35);
        // A straight front lies on the slope.
        assert!(front_margin(&model, -50.0, 0.0) > 0.25);
    }

    /// With 4 kg at a height of 25 cm, the centre of gravity is over axle 2. So the body follows
    /// the front that is raised: the front stays on the slope and the body turns. Such a robot was
    /// seen to turn to -92 degrees.
    #[test]
    fn a_body_that_tips_over_axle_2_runs_out_of_front_margin() {
        let mut settings = Settings::default();
        for (setting, value) in [
            (Setting::PayloadMass, 4_000),
            (Setting::PayloadForward, 160_000),
            (Setting::PayloadUp, 250_000),
        ] {
            settings.set(setting.description().key, value).unwrap();
        }
        let model = Model::new(&settings);
        let payload = (4.0, [0.16, 0.25]);
        assert!(behind_axle_2(-50.0, 0.0, payload) < 0.01);
        let mut before = f32::INFINITY;
        for theta in 0..=42 {
            let theta = f64::from(theta);
            let margin = front_margin(&model, -50.0 - theta, theta);
            assert!(margin < before, "{theta}: {margin}");
            assert!(theta < 22.0 || margin < 0.05, "{theta}: {margin}");
            before = margin;
        }
        assert!(before < 0.0);
    }

    /// On a side slope the robot turns over the lower line between axles 1 and 2, where its belt
    /// lies. The expected margins come from a plane figure in the cross section.
    #[test]
    fn a_front_raised_on_a_side_slope_is_no_support_across() {
        let model = Model::new(&Settings::default());
        let roll = 0.7_f64;
        let mut attitude = Attitude::default();
        let tilted = BodySensors {
            inclination: [0.0, roll as f32],
            ..BodySensors::default()
        };
        attitude.update(&tilted, 1e-3);
        for degrees in [0.0_f64, 30.0, 60.0, 90.0] {
            let shape = model.shape(Angle::from_radians(degrees.to_radians() as f32), 0.23);
            let found = model.stance(&shape, &attitude.level_axes()).margins();
            let height = f64::from(shape.cog[2]) + 0.05;
            let (sine, cosine) = (libm::sin(roll), libm::cos(roll));
            let sides = [1.0, -1.0].map(|side| {
                let across = side * f64::from(shape.cog[1]);
                (f64::from(model.half_gauge) - across) * cosine + side * height * sine
            });
            for (found, expected) in found[2..].iter().zip(sides) {
                assert!(
                    (f64::from(*found) - expected).abs() < 2e-4,
                    "{degrees} {found} {expected}"
                );
            }
        }
    }

    /// Random angles, attitudes, slacks and changes of slack, up to 50 degrees of pitch.
    #[test]
    fn margins_move_continuously_with_the_slack() {
        let settings = Settings::default();
        let (model, geometry) = (
            Model::new(&settings),
            Geometry::from_micrometres(320_000, 230_000, 1_232_000).unwrap(),
        );
        let law = SlackLaw::new(&geometry);
        let mut state = 1_u64;
        let mut random = |low: f64, high: f64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            low + (high - low) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut most = 0.0_f32;
        for _ in 0..100_000 {
            let theta = Angle::from_radians(random(-1.05, 1.75) as f32);
            let mut attitude = Attitude::default();
            let reading = BodySensors {
                inclination: [random(-0.87, 0.87) as f32, random(-0.6, 0.6) as f32],
                ..BodySensors::default()
            };
            attitude.update(&reading, 1e-3);
            let margins = |slack: f32| {
                let length = law.extension(geometry.extension(theta), slack).length;
                let length = metres(length.max(geometry.released_length()));
                model
                    .stance(&model.shape(theta, length), &attitude.level_axes())
                    .margins()
            };
            let slack = random(0.0, 0.12) as f32;
            let step = random(2e-5, 2e-3) as f32;
            let (now, next) = (margins(slack), margins(slack + step));
            for (now, next) in now.into_iter().zip(next) {
                // The last digits of a margin are 0.1 um.
                most = most.max(((next - now).abs() - 1e-6) / step);
            }
        }
        assert!(most < 0.8, "{most} m per metre of slack");
    }
}
