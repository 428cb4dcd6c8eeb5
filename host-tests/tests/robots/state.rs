//! Tests of the state q on B2P2's plant, with the guard's sensors and GNSS receiver, and belts that
//! move as commanded.

use crate::stamp;
use core::f64::consts::TAU;
use tautrack::estimate::attitude::Attitude;
use tautrack::estimate::attitude::pitch_and_roll;
use tautrack::estimate::state::{Estimator, Joint, State, Validity};
use tautrack::link::{BodyMeasurands, Shaft};
use tautrack::sensors::{BodySensors, Fresh};
use tautrack::settings::{Setting, Settings};
use tautrack_host_tests::robots::b2p2::plant::{B2p2, B2p2Parameters};
use tautrack_host_tests::world::Plant;
use tautrack_host_tests::world::ground::Ground;

/// Readings of exact sensors that measure in every step.
fn readings(acts: BodyMeasurands) -> BodySensors {
    BodySensors {
        inclination: pitch_and_roll(acts.tilt_force),
        specific_force: acts.specific_force,
        angular_rate: acts.angular_rate,
        magnetic_field: acts.magnetic_field,
        fresh: Fresh::ALL,
    }
}

/// B2P2 on flat ground, with its chassis straight and its belts taut.
struct Ride {
    parameters: B2p2Parameters,
    plant: B2p2,
    estimator: Estimator,
    attitude: Attitude,
    turns: [f64; 2],
    step: u64,
    /// True place of axle 1 when the position was first accepted.
    origin: Option<[f64; 3]>,
    garbage: bool,
}

impl Ride {
    fn new(change: impl FnOnce(&mut B2p2Parameters)) -> Self {
        let mut parameters = B2p2Parameters::nominal();
        change(&mut parameters);
        let mut settings = Settings::default();
        let [_, _, declination] = parameters.body_sensors.earth_field;
        let iron = parameters.body_sensors.hard_iron;
        for (setting, value) in [
            (Setting::Declination, declination.to_degrees()),
            (Setting::HardIronForward, iron[0]),
            (Setting::HardIronLeft, iron[1]),
            (Setting::HardIronUp, iron[2]),
        ] {
            settings
                .set(setting.description().key, (value * 1e3).round() as i32)
                .expect("within its bounds");
        }
        Self {
            plant: B2p2::new(&parameters, &Ground::Flat, 5),
            parameters,
            estimator: Estimator::new(&settings),
            attitude: Attitude::default(),
            turns: [0.0; 2],
            step: 0,
            origin: None,
            garbage: false,
        }
    }

    /// Drives with these belt speeds, m/s. If `received`, the estimator gets the belts' positions
    /// every 4 ms.
    fn drive(&mut self, belts: [f64; 2], seconds: f64, received: bool) -> State {
        let radius = self.parameters.pulley_radius;
        for _ in 0..(seconds * 1e3) as u32 {
            self.step += 1;
            let now_us = self.step * 1_000;
            let shafts = [0, 1].map(|side| {
                self.turns[side] += belts[side] / radius / TAU * 1e-3;
                Some(Shaft {
                    position: (self.turns[side] * 4_294_967_296.0) as i64,
                    velocity: (belts[side] / radius) as f32,
                })
            });
            let still = Some(Shaft::default());
            self.plant.step(&[shafts[0], shafts[1], still, still]);
            let sensors = readings(self.plant.body_sensors());
            assert!(self.attitude.update(&sensors, 1e-3));
            self.estimator.sense(&sensors, &mut self.attitude, now_us);
            if self.garbage {
                let noise: Vec<u8> = (0..4)
                    .map(|byte| (self.step * 89 + byte * 7) as u8)
                    .collect();
                self.estimator.listen(&noise, now_us);
            } else {
                self.estimator.listen(self.plant.serial(), now_us);
            }
            if self.step.is_multiple_of(4) && received {
                let way = f64::midpoint(self.turns[0], self.turns[1]) * TAU * radius;
                let joints = [Joint {
                    value: 0.25,
                    received_us: Some(now_us),
                }; 2];
                self.estimator.advance(
                    (way * 1e6) as i32,
                    Some(now_us),
                    joints,
                    &self.attitude,
                    now_us,
                );
            }
            if self.origin.is_none() && self.state()[0].validity == Validity::Measured {
                self.origin = Some(self.plant.truth().axle_1);
            }
        }
        self.state()
    }

    fn state(&self) -> State {
        self.estimator.state(&self.attitude, self.step * 1_000)
    }

    /// Horizontal distance between estimate and ground truth, m, both relative to the origin.
    fn error(&self) -> f64 {
        let [north, east, _] = self.estimator.position().metres().map(f64::from);
        let (truth, origin) = (self.plant.truth().axle_1, self.origin.expect("a position"));
        (north - (truth[0] - origin[0])).hypot(-east - (truth[1] - origin[1]))
    }

    /// Error of the heading, degrees.
    fn heading_error(&self) -> f64 {
        let error = f64::from(self.state()[3].value) - self.plant.truth().yaw;
        (error + TAU / 2.0).rem_euclid(TAU).to_degrees() - 180.0
    }
}

fn validities(state: &State) -> [Validity; 8] {
    state.map(|reading| reading.validity)
}

use Validity::{Invalid, Measured, Reckoned, Stale};

#[test]
fn nothing_is_valid_before_it_was_measured_and_everything_after() {
    let mut ride = Ride::new(|_| {});
    assert_eq!(validities(&ride.state()), [Invalid; 8]);
    let state = ride.drive([0.0; 2], 1.5, true);
    assert_eq!(
        validities(&state),
        [
            Invalid, Invalid, Invalid, Measured, Measured, Measured, Measured, Measured
        ]
    );
    let state = ride.drive([0.0; 2], 3.0, true);
    assert_eq!(validities(&state), [Measured; 8]);
    assert!(
        state[..3].iter().all(|reading| reading.age_ms <= 260),
        "{state:?}"
    );
    assert!(ride.estimator.sentences().all_refused() == 0);
    let (place, altitude_mm) = ride.estimator.position().origin().expect("a position");
    // Within the receiver's error of 47.4784 N, 0.5632 W, 40 m; 1e-7 degree is 11 mm of latitude
    // and 7.5 mm of longitude.
    assert!((place.latitude - 474_784_000).abs() < 400, "{place:?}");
    assert!((place.longitude + 5_632_000).abs() < 600, "{place:?}");
    assert!((altitude_mm.expect("an altitude") - 40_000).abs() < 9_000);
}

#[test]
fn the_heading_is_true_north_s_all_the_way_round() {
    let Some(_stamp) = stamp("the_heading_is_true_north_s_all_the_way_round") else {
        return;
    };
    let mut worst = 0.0_f64;
    for start in [0.4, 3.1] {
        let mut ride = Ride::new(|p| p.initial_heading_and_y = [start, 0.0]);
        ride.drive([0.0; 2], 0.5, true);
        for _ in 0..40 {
            ride.drive([-0.05, 0.05], 0.5, true);
            worst = worst.max(ride.heading_error().abs());
            assert_eq!(ride.state()[3].validity, Measured);
        }
    }
    println!("worst heading error while turning on the spot: {worst:.2} degrees");
    assert!(worst < 2.0, "{worst} degrees");
}

#[test]
fn an_outage_leaves_dead_reckoning_with_a_growing_age() {
    let Some(_stamp) = stamp("an_outage_leaves_dead_reckoning_with_a_growing_age") else {
        return;
    };
    let mut ride = Ride::new(|p| {
        p.receiver.outage_s = [12.0, 62.0];
        p.initial_heading_and_y = [1.0, 0.0];
    });
    ride.drive([0.2; 2], 12.5, true);
    assert_eq!(ride.state()[0].validity, Measured);
    let before = ride.error();
    let mut age_ms = 0;
    for second in 0..48 {
        let turn = if second % 16 < 8 { 0.02 } else { -0.02 };
        let state = ride.drive([0.2 - turn, 0.2 + turn], 1.0, true);
        for reading in &state[..3] {
            assert!(second < 1 || reading.validity == Reckoned, "{state:?}");
        }
        assert!(state[0].age_ms >= age_ms + 900, "{state:?}");
        age_ms = state[0].age_ms;
    }
    assert!(age_ms > 47_000);
    let drift = (ride.error() - before).abs() / (48.0 * 0.2);
    println!("dead reckoning on flat ground, 48 s: {drift:.4} m per m");
    assert!(drift < 0.03, "{drift} m per m");
    let state = ride.drive([0.0; 2], 4.0, true);
    assert_eq!(state[0].validity, Measured);
}

#[test]
fn without_encoders_the_position_goes_stale_and_does_not_move() {
    let mut ride = Ride::new(|p| p.receiver.outage_s = [6.0, 60.0]);
    ride.drive([0.2; 2], 8.0, true);
    let before = ride.state();
    let state = ride.drive([0.2; 2], 3.0, false);
    assert_eq!(
        validities(&state),
        [
            Stale, Stale, Stale, Measured, Measured, Measured, Stale, Stale
        ]
    );
    assert_eq!(state[0].value, before[0].value);
}

#[test]
fn garbage_on_the_line_leaves_the_position_invalid() {
    let Some(_stamp) = stamp("garbage_on_the_line_leaves_the_position_invalid") else {
        return;
    };
    let mut ride = Ride::new(|_| {});
    ride.garbage = true;
    let state = ride.drive([0.2; 2], 20.0, true);
    assert_eq!(
        validities(&state),
        [
            Invalid, Invalid, Invalid, Measured, Measured, Measured, Measured, Measured
        ]
    );
}

#[test]
fn a_magnetometer_that_repeats_itself_is_no_compass_for_long() {
    let mut ride = Ride::new(|_| {});
    ride.drive([0.0; 2], 1.0, true);
    for _ in 0..1_000 {
        ride.step += 1;
        let now_us = ride.step * 1_000;
        let sensors = readings(ride.plant.body_sensors());
        ride.attitude.update(&sensors, 1e-3);
        ride.estimator.sense(&sensors, &mut ride.attitude, now_us);
    }
    let heading = ride.state()[3];
    assert_eq!(heading.validity, Reckoned);
    assert!(heading.age_ms >= 900, "{heading:?}");
}
