//! Compares the simulated motors with their equations.

use tautrack::link::{MotorModel, Shaft, ThreePhaseModel, WindingModel};
use tautrack::motor::bridge::{PowerStage, Ratings};
use tautrack::motor::model::Motor;

const STAGE: Ratings = Ratings {
    pwm_hz: 20_000,
    period: 4_250,
    highest: 4_250,
    sampled: 4_250,
    full_scale: 160.0,
    highest_supply: f32::INFINITY,
};
const BRUSHED: MotorModel = MotorModel {
    winding: WindingModel::Brushed {
        resistance: 0.3,
        inductance: 2e-4,
        torque_constant: 0.05,
    },
    rotor_inertia: 1e-4,
    gear_ratio: 50.0,
    friction_torque: 1.0,
    brake_torque: 0.0,
    encoder_counts: 4_096,
    current_noise: 0.0,
    current_quantum: 0.0,
    dead_time: 0.0,
};
const WINDING: ThreePhaseModel = ThreePhaseModel {
    resistance: 0.3,
    inductance: [2e-4, 3e-4],
    flux: 0.006,
    pole_pairs: 7,
    offset_degrees: 30.0,
    cogging_torque: 0.0,
    cogging_periods: 42,
};
const THREE_PHASE: MotorModel = MotorModel {
    winding: WindingModel::ThreePhase(WINDING),
    ..BRUSHED
};

fn motor(model: MotorModel) -> Motor {
    Motor::new(model, STAGE, 1).unwrap()
}

/// Compare values that put `part` of the supply voltage between half bridges a and b.
fn between_a_and_b(part: f64) -> PowerStage {
    let half = f64::from(STAGE.period) / 2.0;
    let [a, b] = [1.0 + part, 1.0 - part].map(|share| (half * share).round() as u16);
    PowerStage::Drive([a, b, half as u16])
}

fn current_a(motor: &mut Motor) -> f64 {
    (f64::from(motor.readings().currents[0]) - 32_768.0) * f64::from(STAGE.full_scale) / 32_768.0
}

#[test]
fn a_brushed_motor_settles_where_its_equation_says() {
    let mut motor = motor(BRUSHED);
    for _ in 0..40_000 {
        motor.set_load(24.0, 10.0);
        motor.integrate(between_a_and_b(0.5));
    }
    // 12 V = R i + k w with k i N = load + friction
    let current = 11.0 / 50.0 / 0.05;
    let velocity = (12.0 - 0.3 * current) / 0.05 / 50.0;
    let (measured, shaft) = (current_a(&mut motor), f64::from(motor.shaft().velocity));
    assert!((measured - current).abs() < 0.02, "{measured}");
    assert!((shaft - velocity).abs() < 0.02, "{shaft}");
}

/// Solves the same three phases in their own axes, without any transform: phase currents that add
/// up to zero, and a sinusoidal back-EMF. `steps` Euler steps a period.
struct Phases {
    currents: [f64; 3],
    electrical: f64,
    speed: f64,
}

impl Phases {
    fn integrate(&mut self, compare: [u16; 3], supply: f64, steps: u32) {
        let (r, inductance, flux) = (0.3, 2e-4, 0.006);
        let dt = 1.0 / f64::from(STAGE.pwm_hz) / f64::from(steps);
        let volts = compare.map(|count| f64::from(count) / f64::from(STAGE.period) * supply);
        for _ in 0..steps {
            let emf: [f64; 3] = std::array::from_fn(|phase| {
                let lag = phase as f64 * std::f64::consts::TAU / 3.0;
                -self.speed * flux * (self.electrical - lag).sin()
            });
            let star = (0..3).map(|phase| volts[phase] - emf[phase]).sum::<f64>() / 3.0;
            for phase in 0..3 {
                let drive = volts[phase] - star - emf[phase] - r * self.currents[phase];
                self.currents[phase] += drive / inductance * dt;
            }
            self.electrical += self.speed * dt;
        }
    }
}

#[test]
fn three_phases_follow_their_equations_in_their_own_axes() {
    // A rotor that turns at a constant speed, because it is too heavy to change it.
    let model = MotorModel {
        winding: WindingModel::ThreePhase(ThreePhaseModel {
            inductance: [2e-4; 2],
            ..WINDING
        }),
        rotor_inertia: 1e6,
        friction_torque: 0.0,
        ..THREE_PHASE
    };
    // At rest: a constant voltage gives the current of the resistances, in every phase.
    let mut motor = motor(model);
    let mut phases = Phases {
        currents: [0.0; 3],
        electrical: 0.0,
        speed: 0.0,
    };
    for step in 0..400_u32 {
        let swing = |lag: f64| {
            let phase = (f64::from(step) * 0.02 - lag).sin();
            (2_125.0 + 300.0 * phase).round() as u16
        };
        let compare = [0.0, 2.1, 4.2].map(swing);
        motor.set_load(24.0, 0.0);
        motor.integrate(PowerStage::Drive(compare));
        phases.integrate(compare, 24.0, 200);
        let readings = motor.readings().currents;
        for (code, expected) in readings.into_iter().zip(phases.currents) {
            let got = (f64::from(code) - 32_768.0) * 160.0 / 32_768.0;
            assert!((got - expected).abs() < 0.15, "{step}: {got} {expected}");
        }
    }
}

#[test]
fn a_three_phase_motor_turns_as_fast_as_its_flux_allows_and_draws_what_its_load_requires() {
    use tautrack::motor::current::{BridgeDemand, Config, CurrentLoop, MotorKind};
    use tautrack::motor::rotor::{ElectricalAngle, Mounting, RotorSensor};
    let config = Config {
        kind: MotorKind::ThreePhase,
        resistance: 0.3,
        inductance: [2e-4, 3e-4],
        torque_constant: 1.5 * 7.0 * 0.006,
        current_limit: 20.0,
        bandwidth: 3_000.0,
        gear_ratio: 50.0,
        mounting: Mounting {
            counts_per_turn: 4_096,
            pole_pairs: 7,
            offset: ElectricalAngle::from_milli_degrees(30_000),
            reversed: false,
        },
        sensor: RotorSensor::Absolute,
        dead_time: 0.6e-6,
        continuous_current: 10.0,
        periods_per_control: 20,
    };
    for (current, load) in [(5.0, 12.0), (-5.0, -12.0)] {
        let mut current_loop = CurrentLoop::new(&config, &STAGE).unwrap();
        let mut motor = motor(MotorModel {
            dead_time: 0.6e-6,
            ..THREE_PHASE
        });
        let mut stage = PowerStage::Off;
        let mut before = 0.0;
        for period in 0..4_000 {
            if period % 20 == 0 {
                let velocity = motor.shaft().velocity;
                current_loop.demand(BridgeDemand::Current(current), 24.0, velocity);
            }
            if period == 2_000 {
                before = f64::from(motor.shaft().velocity);
            }
            let next = current_loop.period(&motor.readings());
            motor.set_load(24.0, load);
            motor.integrate(stage);
            stage = next;
        }
        // J dw/dt = k i - (load + friction) / N, at the rotor.
        let torque = 1.5 * 7.0 * 0.006 * f64::from(current);
        let friction = f64::from(load).signum();
        let acceleration = (torque - (f64::from(load) + friction) / 50.0) / 1e-4 / 50.0;
        let measured = (f64::from(motor.shaft().velocity) - before) / 0.1;
        assert!(
            (measured / acceleration - 1.0).abs() < 0.02,
            "{current} A: {measured} rad/s^2, expected {acceleration}"
        );
    }
}

#[test]
fn friction_holds_a_load_below_it_and_yields_above() {
    for model in [BRUSHED, THREE_PHASE] {
        let mut motor = motor(model);
        for _ in 0..2_000 {
            motor.set_load(24.0, 0.99);
            motor.integrate(PowerStage::Off);
        }
        assert_eq!(motor.shaft(), Shaft::default());
        motor.set_load(24.0, 1.01);
        motor.integrate(PowerStage::Off);
        assert!(motor.shaft().velocity < 0.0);
    }
}

#[test]
fn position_is_the_integral_of_velocity() {
    for model in [BRUSHED, THREE_PHASE] {
        let mut motor = motor(model);
        let mut angle = 0.0_f64;
        for period in 0..200_000 {
            motor.set_load(24.0, if period < 2_000 { -30.0 } else { 0.0 });
            motor.integrate(PowerStage::Off);
            angle += f64::from(motor.shaft().velocity) * 50.0 / 20_000.0;
        }
        let turns = angle / core::f64::consts::TAU;
        let counts = f64::from(motor.encoder());
        assert!(turns > 1.0, "{turns}");
        assert!((counts - turns * 4_096.0).abs() < 1.0 + turns * 4_096.0 * 1e-5);
    }
}

#[test]
fn an_open_bridge_ends_the_current_and_never_reverses_it() {
    for model in [BRUSHED, THREE_PHASE] {
        let mut motor = motor(model);
        for _ in 0..100 {
            motor.set_load(24.0, 0.0);
            motor.integrate(between_a_and_b(0.9));
        }
        let first = current_a(&mut motor);
        assert!(first > 1.0, "{first}");
        for _ in 0..200 {
            motor.set_load(24.0, 0.0);
            motor.integrate(PowerStage::Off);
        }
        assert!(current_a(&mut motor).abs() < 0.01);
    }
}

#[test]
fn driven_faster_than_the_supply_an_open_bridge_brakes() {
    for model in [BRUSHED, THREE_PHASE] {
        let mut motor = motor(model);
        let (mut slowest, mut fastest) = (f32::INFINITY, 0.0_f32);
        // A load of 50 N m accelerates the shaft until the back-EMF exceeds the supply.
        for period in 0..40_000 {
            motor.set_load(24.0, -50.0);
            motor.integrate(PowerStage::Off);
            let speed = motor.shaft().velocity;
            fastest = fastest.max(speed);
            if period > 30_000 {
                slowest = slowest.min(speed);
            }
        }
        assert!(fastest < 60.0 && slowest > 5.0, "{slowest} {fastest}");
        assert!((fastest - slowest) / fastest < 0.2, "{slowest} {fastest}");
    }
}

#[test]
fn everything_stays_finite() {
    let values = [
        0.0,
        1.0,
        -1.0,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    for model in [BRUSHED, THREE_PHASE] {
        let mut motor = motor(MotorModel {
            rotor_inertia: 1e-9,
            ..model
        });
        for voltage in values {
            for torque in values {
                for stage in [
                    PowerStage::Drive([4_250, 0, 2_125]),
                    PowerStage::Drive([u16::MAX, 0, 7]),
                    PowerStage::Brake,
                    PowerStage::Off,
                ] {
                    motor.set_load(voltage, torque);
                    motor.integrate(stage);
                    assert!(motor.shaft().velocity.is_finite());
                    motor.readings();
                }
            }
        }
    }
}

#[test]
fn refuses_a_motor_that_cannot_be_simulated() {
    let bad = |model| Motor::new(model, STAGE, 1).is_none();
    assert!(bad(MotorModel {
        rotor_inertia: 0.0,
        ..BRUSHED
    }));
    assert!(bad(MotorModel {
        dead_time: f32::NAN,
        ..BRUSHED
    }));
    for winding in [
        ThreePhaseModel {
            pole_pairs: 0,
            ..WINDING
        },
        ThreePhaseModel {
            flux: -1.0,
            ..WINDING
        },
        ThreePhaseModel {
            inductance: [2e-4, 0.0],
            ..WINDING
        },
    ] {
        assert!(bad(MotorModel {
            winding: WindingModel::ThreePhase(winding),
            ..BRUSHED
        }));
    }
}
