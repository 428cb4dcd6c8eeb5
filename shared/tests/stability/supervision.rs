//! Tests the guard's supervision against integrated falls and against any input.

use proptest::prelude::*;
use tautrack::estimate::attitude::Attitude;
use tautrack::estimate::specific_force::SpecificForce;
use tautrack::sensing::trust::Trust;
use tautrack::sensing::watch::{Expectations, Watch};
use tautrack::sensors::BodySensors;
use tautrack::settings::Settings;
use tautrack::stability::allowed::Command;
use tautrack::stability::bands::{Band, Bands};
use tautrack::stability::criterion::Criterion;
use tautrack::stability::energy::{Rotation, Tipping, stopping_speed};
use tautrack::stability::filter::{Bounds, Margins, Ramp, Tracker, posture, speed_scale};
use tautrack::stability::limits::MotionLimits;
use tautrack::stability::parameters::Parameters;
use tautrack::stability::support::{Stance, narrowest};
use tautrack::stability::trip::{Cause, Inputs, Mode, Requests, Snapshot, Trip};

const G: f64 = 9.81;

/// Whether a point mass on a massless robot, which pivots about its front edge, falls over when the
/// robot brakes from `speed` with `deceleration`. The mass is `margin` m behind the edge and
/// `height` m above it. Integrates with steps of 10 us and uses no formula of the library.
fn falls(margin: f64, height: f64, speed: f64, deceleration: f64) -> bool {
    const STEP: f64 = 1e-5;
    let lever = margin.hypot(height);
    let standing = margin.atan2(height);
    // Angle of the lever to the vertical over the edge; the robot falls over when it is below zero.
    let (mut angle, mut rate, mut braking) = (standing, 0.0, speed);
    if deceleration.is_infinite() {
        // The stop preserves the angular momentum about the edge.
        (rate, braking) = (-speed * height / (lever * lever), 0.0);
    }
    for _ in 0..500_000 {
        let inertia = if braking > 0.0 { deceleration } else { 0.0 };
        braking -= deceleration.min(1e9) * STEP;
        rate += (G * angle.sin() - inertia * angle.cos()) / lever * STEP;
        angle += rate * STEP;
        if angle >= standing {
            (angle, rate) = (standing, 0.0);
            if braking <= 0.0 {
                return false;
            }
        }
        if angle < 0.0 {
            return true;
        }
    }
    false
}

/// Largest deceleration from this speed that does not tip such a robot, by bisection.
fn bearable(margin: f64, height: f64, speed: f64) -> f64 {
    if !falls(margin, height, speed, f64::INFINITY) {
        return f64::INFINITY;
    }
    let (mut bears, mut falls_at) = (0.0, 1e3);
    while falls_at - bears > 1e-3 * falls_at {
        let middle = 0.5 * (bears + falls_at);
        if falls(margin, height, speed, middle) {
            falls_at = middle;
        } else {
            bears = middle;
        }
    }
    bears
}

/// From this speed on, the margin of the centre of gravity alone is not a sufficient criterion: an
/// instant stop begins to tip a robot that has exactly this margin.
#[test]
fn below_the_stopping_speed_no_deceleration_tips_the_robot() {
    for (margin, height) in [
        (0.05, 0.1),
        (0.05, 0.25),
        (0.05, 0.35),
        (0.1, 0.35),
        (0.05, 0.6),
    ] {
        let critical = f64::from(stopping_speed(margin as f32, height as f32));
        assert!(
            !falls(margin, height, 0.99 * critical, f64::INFINITY),
            "{margin} {height}"
        );
        assert!(
            falls(margin, height, 1.01 * critical, f64::INFINITY),
            "{margin} {height}"
        );
        println!("margin {margin} m, height {height} m: {critical:.3} m/s");
    }
}

/// Compares two decelerations of B2P2 at its stop margin, with its centre of gravity as high as on
/// the staircase: the one that it withstands, and the configured one.
#[test]
fn the_deceleration_handed_down_is_borne_at_any_speed_and_the_configured_one_at_the_stop_margin() {
    let parameters = Parameters::new(&Settings::default());
    let (margin, height) = (f64::from(parameters.stop), 0.35);
    // The bound from which the limits are computed, for a stop of any duration.
    let lasting = G * margin / height;
    assert!(f64::from(parameters.acceleration) < lasting);
    for speed in [0.1, 0.2, 0.3, 0.5, 1.0, 2.0] {
        let most = bearable(margin, height, speed);
        println!(
            "{speed} m/s: bears {most:.2} m/s^2, configured {:.2}",
            parameters.acceleration
        );
        assert!(most > 0.999 * lasting, "{speed}: {most} < {lasting}");
    }
}

fn any_f32() -> impl Strategy<Value = f32> {
    prop_oneof![any::<u32>().prop_map(f32::from_bits), -1.0_f32..1.0]
}

fn point() -> impl Strategy<Value = [f32; 3]> {
    [any_f32(), any_f32(), any_f32()]
}

fn ramp() -> impl Strategy<Value = Ramp> {
    (any_f32(), any_f32()).prop_map(|(none, all)| Ramp { none, all })
}

fn stance() -> impl Strategy<Value = Stance> {
    let contact = || proptest::option::weighted(0.8, point());
    ([contact(), contact(), contact(), contact()], point())
        .prop_map(|(contacts, cog)| Stance::on_some(contacts, cog))
}

fn sensors() -> impl Strategy<Value = BodySensors> {
    ([any_f32(), any_f32()], point(), point(), point()).prop_map(
        |(inclination, specific_force, angular_rate, magnetic_field)| BodySensors {
            inclination,
            specific_force,
            angular_rate,
            magnetic_field,
            ..BodySensors::default()
        },
    )
}

fn within(passed: f32, asked: f32) -> bool {
    passed == 0.0 || (passed.signum() == asked.signum() && passed.abs() <= asked.abs())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_margins_leave_a_share_between_nothing_and_all(
        now in [any_f32(), any_f32(), any_f32(), any_f32()],
        rate in [any_f32(), any_f32(), any_f32(), any_f32()],
        ahead in [any_f32(), any_f32(), any_f32(), any_f32()],
        speeds in [any_f32(), any_f32(), any_f32(), any_f32()],
        ramps in [ramp(), ramp()],
        [horizon, foresight, half_width] in [any_f32(), any_f32(), any_f32()],
        [height, arm, turns, gyration] in [any_f32(), any_f32(), any_f32(), any_f32()],
        [fastest, braking] in [any_f32(), any_f32()],
        noses in any::<bool>(),
    ) {
        let [forward, yaw_rate, speed, pitch] = speeds;
        let margins = Margins { now, rate, speed };
        let [towards, away] = ramps;
        let tipping = [Tipping { height, arm, rate: turns, gyration }; 4];
        let bounds = Bounds {
            towards,
            away,
            horizon,
            foresight,
            tipping,
            half_width,
            fastest,
            braking,
            noses,
        };
        let driven = speed_scale(Command::new(forward, yaw_rate), pitch, &margins, &bounds);
        for (speed_scale, _) in [driven, posture(pitch, &margins, ahead, &bounds)] {
            prop_assert!((0.0..=1.0).contains(&speed_scale), "{}", speed_scale);
        }
    }

    #[test]
    fn whatever_comes_in_more_than_asked_never_passes_and_bad_data_is_never_free(
        steps in proptest::collection::vec(
            (
                (stance(), proptest::option::of(sensors()), 0.0_f32..0.02),
                ([any_f32(), any_f32()], any::<[bool; 5]>(), any::<bool>()),
            ),
            1..60,
        ),
        again in any::<bool>(),
    ) {
        let parameters = Parameters::new(&Settings::default());
        let (mut watch, mut attitude) = (Watch::new(&Expectations { stuck_readings: 3, rates: [1_000.0; 4] }), Attitude::default());
        let (mut force, mut criterion) = (SpecificForce::default(), Criterion::default());
        let mut rotation = Rotation::default();
        let (mut bands, mut trip, mut tracker) = (Bands::default(), Trip::default(), Tracker::default());
        // Half of the cases also repeat the steps in reverse order.
        let order: Vec<_> = if again {
            steps.iter().chain(steps.iter().rev()).collect()
        } else {
            steps.iter().collect()
        };
        for ((stance, reading, period), ([forward, yaw_rate], flags, armed)) in order {
            let fresh = watch.receive(reading.as_ref(), *period);
            let usable = BodySensors { fresh, ..reading.unwrap_or_default() };
            attitude.update(&usable, *period);
            if fresh.accelerometer {
                force.receive(usable.specific_force);
            }
            let level = force.advance(&attitude.level_axes(), *period);
            let found = criterion.evaluate(stance, level, *forward, &parameters);
            watch.compare(level, &attitude, !found.stop_would_tip, *period);
            let margins = if matches!(watch.trust(), Trust::None(_)) { [f32::NAN; 4] } else { found.margins };
            let limits = MotionLimits::of(&found, &parameters);
            let (along, across) = (0.1 - 1e-6..=parameters.braking, -1e-6..=parameters.acceleration);
            prop_assert!(along.contains(&limits.forward) && along.contains(&limits.backward), "{:?}", limits);
            prop_assert!(across.contains(&limits.left) && across.contains(&limits.right), "{:?}", limits);
            let band = bands.update(&margins, *period, &parameters);
            if margins.iter().any(|margin| !margin.is_finite()) {
                prop_assert!(band >= Band::Limit);
            }
            let asked = Command::new(*forward, *yaw_rate);
            let inputs = Inputs {
                armed: *armed,
                band,
                trust: watch.trust(),
                odometry_um: (*forward * 1e6) as i32,
                snapshot: Snapshot {
                    cause: Cause::EmergencyStop,
                    time_us: 0,
                    margins,
                    edge: narrowest(&margins),
                    command: asked,
                    speed: *forward,
                    sensors: reading.unwrap_or_default(),
                },
            };
            let [reset, override_trip, back_off, emergency_stop, _] = *flags;
            let requests = Requests { reset, override_trip, back_off, emergency_stop };
            let mode = trip.update(&inputs, requests, &parameters);
            let admitted = mode.admit(asked, &parameters);
            if !matches!(mode, Mode::BackingOff(_)) && asked.forward.is_finite() {
                let tracked = tracker.update(stance, &found, &found.gravity, *forward, *period);
                rotation.update(stance, attitude.level(usable.angular_rate), *period);
                let tipping = rotation.tipping(stance, &found, 0.0, 0.05);
                let bounds = parameters.bounds(0.3, 1.5, tipping);
                let (speed_scale, _) =
                    speed_scale(admitted, attitude.pitch().radians(), &tracked, &bounds);
                prop_assert!(within(admitted.forward * speed_scale, asked.forward), "{:?} {}", admitted, speed_scale);
                let yaw_rate = limits.yaw_rate(admitted.yaw_rate, *forward);
                prop_assert!(within(yaw_rate, asked.yaw_rate), "{:?} {}", asked, yaw_rate);
                if emergency_stop {
                    prop_assert_eq!(admitted, Command::default());
                }
            }
        }
    }
}
