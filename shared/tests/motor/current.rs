//! Compares the current control with double precision, and with simulated motors.

use proptest::prelude::*;
use std::f64::consts::TAU;
use tautrack::motor::bridge::{CurrentSensing, MAX_DUTY, PowerStage, Ratings, Readings};
use tautrack::motor::current::{BridgeDemand, Config, CurrentLoop, CurrentLoopError, MotorKind};
use tautrack::motor::rotor::{ElectricalAngle, Mounting, RotorSensor};

const STAGE: Ratings = Ratings {
    pwm_hz: 20_000,
    period: 4_250,
    highest: 4_250,
    sampled: 4_250,
    full_scale: 32.0,
    highest_supply: f32::INFINITY,
};
const MOUNTING: Mounting = Mounting {
    counts_per_turn: 4_096,
    pole_pairs: 7,
    offset: ElectricalAngle(tautrack::units::Angle::ZERO),
    reversed: false,
};
const THREE_PHASE: Config = Config {
    kind: MotorKind::ThreePhase,
    resistance: 0.4,
    inductance: [3e-4, 4e-4],
    torque_constant: 0.105,
    current_limit: 20.0,
    bandwidth: 2_000.0,
    gear_ratio: 1.0,
    mounting: MOUNTING,
    sensor: RotorSensor::Absolute,
    dead_time: 0.0,
    continuous_current: 10.0,
    periods_per_control: 20,
};
const BRUSHED: Config = Config {
    kind: MotorKind::Brushed,
    ..THREE_PHASE
};
const SUPPLY: f64 = 24.0;
const PERIOD_S: f64 = 1.0 / STAGE.pwm_hz as f64;

fn flux(config: &Config) -> f64 {
    f64::from(config.torque_constant) / 1.5 / f64::from(config.mounting.pole_pairs)
}

fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [x * cos - y * sin, x * sin + y * cos]
}

fn code(amperes: f64) -> u16 {
    let code = 32_768.0 + amperes / f64::from(STAGE.full_scale) * 32_768.0;
    code.round().clamp(0.0, 65_535.0) as u16
}

fn amperes(code: u16) -> f64 {
    (f64::from(code) - 32_768.0) / 32_768.0 * f64::from(STAGE.full_scale)
}

/// Codes of the phases a and b for a current in the rotor's axes at the electrical angle `angle`.
fn codes(dq: [f64; 2], angle: f64) -> [u16; 2] {
    let [alpha, beta] = turned(dq, angle);
    [alpha, -0.5 * alpha + 0.75_f64.sqrt() * beta].map(code)
}

/// Voltage in the rotor's axes that three compare values make at `angle`, V.
fn voltage(counts: [u16; 3], angle: f64) -> [f64; 2] {
    let [a, b, c] = counts.map(|count| f64::from(count) / f64::from(STAGE.period) * SUPPLY);
    turned([(2.0 * a - b - c) / 3.0, (b - c) / 3.0_f64.sqrt()], -angle)
}

fn compare(stage: PowerStage) -> [u16; 3] {
    match stage {
        PowerStage::Drive(compare) => compare,
        other => panic!("{other:?}"),
    }
}

/// The same controller in double precision, in volts and amperes: PI controllers, decoupling,
/// back-EMF and the circle, without the dead time.
#[derive(Default)]
struct Reference {
    integral: [f64; 2],
}

impl Reference {
    fn step(&mut self, c: &Config, current: [f64; 2], demand: f64, speed: f64) -> [f64; 2] {
        let [inductance_d, inductance_q] = c.inductance.map(f64::from);
        let forward = [
            -speed * inductance_q * current[1],
            speed * (inductance_d * current[0] + flux(c)),
        ];
        let radius = SUPPLY * f64::from(MAX_DUTY) / 3.0_f64.sqrt();
        let mut left = radius;
        let mut result = [0.0; 2];
        for axis in 0..2 {
            let (bandwidth, inductance) = (f64::from(c.bandwidth), f64::from(c.inductance[axis]));
            let error = [0.0, demand][axis] - current[axis];
            let integral =
                self.integral[axis] + bandwidth * f64::from(c.resistance) * PERIOD_S * error;
            let wanted = bandwidth * inductance * error + integral + forward[axis];
            let limited = wanted.clamp(-left, left);
            if limited == wanted || wanted * error < 0.0 {
                self.integral[axis] = integral;
            }
            result[axis] = limited;
            left = (radius * radius - limited * limited).max(0.0).sqrt();
        }
        result
    }
}

#[test]
fn a_period_is_that_of_double_precision_to_two_counts() {
    let mut current_loop = CurrentLoop::new(&THREE_PHASE, &STAGE).unwrap();
    let mut reference = Reference::default();
    let count = SUPPLY / f64::from(STAGE.period);
    let (mut worst, mut compared, mut limited) = (0.0_f64, 0, 0);
    let (mut demand, mut speed) = (0.0, 0.0);
    for step in 0..200_000_u32 {
        let t = f64::from(step);
        if step % 20 == 0 {
            demand = 7.0 * (t * 1.7e-3).cos();
            speed = 1_200.0 * (t * 3.1e-4).sin(); // electrical, rad/s
            let shaft = speed / f64::from(MOUNTING.pole_pairs);
            current_loop.demand(
                BridgeDemand::Current(demand as f32),
                SUPPLY as f32,
                shaft as f32,
            );
        }
        let counts = step.wrapping_mul(977) % 4_096;
        let electrical = f64::from(counts) / 4_096.0 * 7.0 * TAU;
        let wanted = [2.5 * (t * 0.01).sin(), demand + 2.0 * (t * 0.013).cos()];
        let codes = codes(wanted, electrical);
        // The converter rounds; the reference sees what it measured.
        let [a, b] = codes.map(amperes);
        let current = turned([a, (a + 2.0 * b) / 3.0_f64.sqrt()], -electrical);
        let expected = reference.step(&THREE_PHASE, current, demand, speed);
        let readings = Readings {
            currents: codes,
            rotor: counts,
            ..Readings::default()
        };
        let counts = compare(current_loop.period(&readings));
        let got = voltage(counts, electrical + 1.5 * speed * PERIOD_S);
        let error = (got[0] - expected[0]).hypot(got[1] - expected[1]) / count;
        let radius = SUPPLY * f64::from(MAX_DUTY) / 3.0_f64.sqrt();
        // At the circle the control stays up to 4.5 % inside, and the integrals part.
        if expected[0].hypot(expected[1]) < 0.95 * radius {
            worst = worst.max(error);
            compared += 1;
        } else {
            limited += 1;
            reference.integral = [0.0; 2];
            current_loop = CurrentLoop::new(&THREE_PHASE, &STAGE).unwrap();
            let shaft = speed / f64::from(MOUNTING.pole_pairs);
            current_loop.demand(
                BridgeDemand::Current(demand as f32),
                SUPPLY as f32,
                shaft as f32,
            );
        }
        let (low, high) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
        let off = i32::from(*low) + i32::from(*high) - i32::from(STAGE.period);
        assert!(off.abs() <= 2, "step {step}: {counts:?} are not centred");
    }
    println!("worst error {worst} counts in {compared} periods, {limited} limited");
    assert!(worst <= 2.0 && compared > 100_000, "{worst}, {compared}");
}

/// Compare value above which a low side conducts too briefly for a sample: 91.8 % of the period.
const SAMPLED: u16 = 3_900;

/// Feeds two loops the same currents. One gets exact samples of a and b. The other one gets three
/// samples, and a wrong one of each half bridge whose low side conducted too briefly: the converter
/// shows no current, or something else.
#[test]
fn a_phase_whose_low_side_conducted_too_briefly_follows_from_the_two_others() {
    let exact_stage = STAGE;
    let brief_stage = Ratings {
        sampled: SAMPLED,
        ..STAGE
    };
    let (mut worst, mut brief, mut wrong_sums) = (0, [0; 3], 0);
    for run in 0..400_u32 {
        let mut loops =
            [exact_stage, brief_stage].map(|stage| CurrentLoop::new(&THREE_PHASE, &stage).unwrap());
        let size = 1_100.0 + f64::from(run) * 0.5;
        let speed = if run % 2 == 0 { size } else { -size }; // electrical, rad/s
        let demand = 6.0 * (f64::from(run) * 0.7).sin();
        let mut before = [0; 3];
        for step in 0..60_u32 {
            if step % 20 == 0 {
                let shaft = speed / f64::from(MOUNTING.pole_pairs);
                for current_loop in &mut loops {
                    let demand = BridgeDemand::Current(demand as f32);
                    current_loop.demand(demand, SUPPLY as f32, shaft as f32);
                }
            }
            let rotor = (run * 4_096 + step * 29) % 4_096;
            let electrical = f64::from(rotor) / 4_096.0 * 7.0 * TAU;
            let t = f64::from(run * 60 + step);
            let dq = [1.5 * (t * 0.3).sin(), demand + 0.5 * (t * 0.2).cos()];
            let [a, b] = codes(dq, electrical);
            let third = code(-amperes(a) - amperes(b));
            let mut samples = [a, b, third];
            for phase in 0..3 {
                if before[phase] > SAMPLED {
                    brief[phase] += 1;
                    samples[phase] = if t % 2.0 == 0.0 { 32_768 } else { 41_000 };
                }
            }
            let readings = Readings {
                currents: [a, b],
                rotor,
                ..Readings::default()
            };
            let exact = compare(loops[0].period(&readings));
            let got = compare(loops[1].period(&Readings {
                currents: [samples[0], samples[1]],
                third: Some(samples[2]),
                ..readings
            }));
            for (exact, got) in exact.iter().zip(got) {
                worst = worst.max((i32::from(*exact) - i32::from(got)).abs());
            }
            before = got;
        }
        let means = loops[1].take_means().unwrap();
        wrong_sums += u32::from(means.electrical.wrong_sum);
    }
    println!("{worst} counts, {brief:?} samples too brief");
    assert!(brief.iter().all(|brief| *brief > 1_000), "{brief:?}");
    assert!(worst <= 3, "{worst} counts");
    assert_eq!(wrong_sums, 0);
}

/// A motor in double precision: the dq equations with Euler steps of a fiftieth of a period, at a
/// constant electrical speed. It has the numbers of `truth`, and the controller those of `config`.
struct Bench {
    current_loop: CurrentLoop,
    truth: Config,
    current: [f64; 2],
    /// Turns of the rotor.
    rotor: f64,
    speed: f64,
    applied: PowerStage,
    supply: f64,
}

impl Bench {
    fn new(config: &Config, truth: &Config, speed: f64) -> Self {
        Self {
            current_loop: CurrentLoop::new(config, &STAGE).unwrap(),
            truth: *truth,
            current: [0.0; 2],
            rotor: 0.123,
            speed,
            applied: PowerStage::Off,
            supply: SUPPLY,
        }
    }

    fn angle(&self) -> f64 {
        let direction = if self.truth.mounting.reversed {
            -1.0
        } else {
            1.0
        };
        let turned = self.rotor * f64::from(self.truth.mounting.pole_pairs) * TAU * direction;
        turned + f64::from(self.truth.mounting.offset.0.to_bits()) * (TAU / 4_294_967_296.0)
    }

    fn demand(&mut self, amperes: f32) {
        let direction = if self.truth.mounting.reversed {
            -1.0
        } else {
            1.0
        };
        let shaft = self.speed * direction / f64::from(self.truth.mounting.pole_pairs);
        let demand = BridgeDemand::Current(amperes);
        self.current_loop
            .demand(demand, self.supply as f32, shaft as f32);
    }

    /// Runs `periods` periods with this demand; returns the currents after each.
    fn run(&mut self, amperes: f32, periods: usize) -> Vec<[f64; 2]> {
        (0..periods)
            .map(|period| {
                if period % 20 == 0 {
                    self.demand(amperes);
                }
                self.period();
                self.current
            })
            .collect()
    }

    fn period(&mut self) {
        let counts = f64::from(self.truth.mounting.counts_per_turn);
        let readings = Readings {
            currents: codes(self.current, self.angle()),
            rotor: (self.rotor.rem_euclid(1.0) * counts) as u32,
            ..Readings::default()
        };
        let next = self.current_loop.period(&readings);
        let dt = PERIOD_S / 50.0;
        let (r, [inductance_d, inductance_q], flux) = (
            f64::from(self.truth.resistance),
            self.truth.inductance.map(f64::from),
            flux(&self.truth),
        );
        let direction = if self.truth.mounting.reversed {
            -1.0
        } else {
            1.0
        };
        for _ in 0..50 {
            let [ud, uq] = match self.applied {
                PowerStage::Drive(counts) => {
                    voltage(counts, self.angle()).map(|volts| volts * self.supply / SUPPLY)
                }
                PowerStage::Brake | PowerStage::Off => [0.0; 2],
            };
            let [d, q] = self.current;
            self.current = [
                d + (ud - r * d + self.speed * inductance_q * q) / inductance_d * dt,
                q + (uq - r * q - self.speed * (inductance_d * d + flux)) / inductance_q * dt,
            ];
            let pole_pairs = f64::from(self.truth.mounting.pole_pairs);
            self.rotor += direction * self.speed * dt / pole_pairs / TAU;
        }
        self.applied = next;
    }
}

/// Time from 10 to 90 % of a loop `di/dt = w (demand - i)` that acts one and a half periods late.
fn predicted_rise(bandwidth: f64) -> f64 {
    let step = PERIOD_S / 1_000.0;
    let mut history = vec![0.0; 1_500];
    while history[history.len() - 1] < 0.9 {
        let late = history[history.len() - 1_500];
        history.push(history[history.len() - 1] + bandwidth * (1.0 - late) * step);
    }
    history.iter().filter(|current| **current >= 0.1).count() as f64 * step
}

#[test]
fn a_current_step_rises_as_its_bandwidth_predicts() {
    let mut bench = Bench::new(&THREE_PHASE, &THREE_PHASE, 0.0);
    let history = bench.run(8.0, 400);
    let first = |part: f64| {
        let period = history.iter().position(|[_, q]| *q >= part * 8.0).unwrap();
        // The time between two samples is interpolated.
        let (before, after) = (history[period - 1][1], history[period][1]);
        (period as f64 + (part * 8.0 - before) / (after - before)) * PERIOD_S
    };
    let (rise, predicted) = (first(0.9) - first(0.1), predicted_rise(2_000.0));
    let peak = history.iter().fold(0.0_f64, |peak, [_, q]| peak.max(*q));
    println!("rise {rise} s, predicted {predicted} s, peak {peak} A");
    assert!((rise / predicted - 1.0).abs() <= 0.1, "{rise} {predicted}");
    assert!(peak <= 8.0 * 1.05, "{peak}");
}

#[test]
fn currents_settle_on_the_demand_at_any_speed() {
    for speed in [0.0, 300.0, -700.0, 900.0] {
        let mut bench = Bench::new(&THREE_PHASE, &THREE_PHASE, speed);
        let history = bench.run(5.0, 4_000);
        let [d, q] = history[3_999];
        assert!(d.abs() < 0.05 && (q - 5.0).abs() < 0.05, "{speed}: {d} {q}");
        // The feed-forward knows the back-EMF, so switching on at speed draws little more.
        let peak = history.iter().fold(0.0_f64, |peak, [_, q]| peak.max(*q));
        assert!(peak < 5.0 * 1.25, "speed {speed}: peak {peak}");
    }
}

#[test]
fn a_reversed_phase_order_and_an_offset_give_the_same_torque() {
    for (reversed, offset) in [(true, 0), (false, 130_000), (true, -70_000)] {
        let mounting = Mounting {
            reversed,
            offset: ElectricalAngle::from_milli_degrees(offset),
            ..MOUNTING
        };
        let config = Config {
            mounting,
            ..THREE_PHASE
        };
        let mut bench = Bench::new(&config, &config, 0.0);
        let [d, q] = bench.run(5.0, 2_000)[1_999];
        let toward_larger_counts = if reversed { -q } else { q };
        assert!(d.abs() < 0.05, "{reversed} {offset}: {d}");
        assert!(
            (toward_larger_counts - 5.0).abs() < 0.05,
            "{reversed} {offset}: {q}"
        );
        assert!((bench.current_loop.take_means().unwrap().current - 5.0).abs() < 0.2);
    }
}

#[test]
fn saturation_leaves_no_windup_behind() {
    let mut bench = Bench::new(&THREE_PHASE, &THREE_PHASE, 1_400.0);
    // 14 V of back-EMF: the bridge cannot drive 15 A against it.
    let stalled = bench.run(15.0, 20_000);
    assert!(stalled[19_999][1] < 14.0);
    bench.speed = 0.0;
    let after = bench.run(0.0, 400);
    // 100 periods are 5 ms: ten time constants of the loop.
    let settled = after[100..].iter().all(|[_, q]| q.abs() < 1.0);
    assert!(settled, "{:?}", after[100]);
}

#[test]
fn the_voltage_vector_stays_in_the_circle_of_the_bridge() {
    let radius = SUPPLY * f64::from(MAX_DUTY) / 3.0_f64.sqrt();
    let count = SUPPLY / f64::from(STAGE.period);
    for step in 0..20_000_i32 {
        let mut current_loop = CurrentLoop::new(&THREE_PHASE, &STAGE).unwrap();
        current_loop.demand(
            BridgeDemand::Current((step % 41 - 20) as f32),
            SUPPLY as f32,
            (step % 401 - 200) as f32,
        );
        let electrical = f64::from(step % 4_096) / 4_096.0 * 7.0 * TAU;
        let t = f64::from(step);
        let currents = codes([12.0 * (t * 0.7).sin(), 12.0 * (t * 0.3).cos()], electrical);
        let readings = Readings {
            currents,
            rotor: (step % 4_096) as u32,
            ..Readings::default()
        };
        let [x, y] = voltage(compare(current_loop.period(&readings)), 0.0);
        assert!(x.hypot(y) <= radius + 2.0 * count, "step {step}: {x} {y} V");
    }
}

/// Runs a brushed winding in double precision, with the exact solution of a period. Returns the
/// last current and the largest.
fn brushed(demand: f32, back_emf: f64, supply: f64, periods: usize) -> (f64, f64, CurrentLoop) {
    let mut current_loop = CurrentLoop::new(&BRUSHED, &STAGE).unwrap();
    let (mut current, mut volts, mut peak) = (0.0_f64, 0.0, 0.0_f64);
    for period in 0..periods {
        if period % 20 == 0 {
            current_loop.demand(BridgeDemand::Current(demand), supply as f32, 0.0);
        }
        (current, volts) = after(&mut current_loop, current, volts, back_emf, supply);
        peak = peak.max(current.abs());
    }
    (current, peak, current_loop)
}

/// One period of a brushed winding: its current, and the voltage of the next period.
fn after(l: &mut CurrentLoop, current: f64, volts: f64, emf: f64, supply: f64) -> (f64, f64) {
    let readings = Readings {
        currents: [code(current), code(-current)],
        ..Readings::default()
    };
    let [a, b, _] = compare(l.period(&readings)).map(f64::from);
    let next = (a - b) / f64::from(STAGE.period) * supply;
    let (r, inductance) = (
        f64::from(BRUSHED.resistance),
        f64::from(BRUSHED.inductance[0]),
    );
    let settled = (volts - emf) / r;
    let decay = (-r * PERIOD_S / inductance).exp();
    (settled + (current - settled) * decay, next)
}

#[test]
fn a_brushed_motor_settles_without_error() {
    // One time constant, and two periods of delay, which make the rise steeper.
    let (risen, ..) = brushed(5.0, 0.0, 24.0, 12);
    assert!((risen - 5.0 * 0.632).abs() < 0.6, "{risen}");
    let (settled, peak, _) = brushed(5.0, 6.0, 24.0, 4_000);
    assert!((settled - 5.0).abs() < 0.01, "{settled}");
    assert!(peak < 11.0, "the step of the back-EMF alone draws {peak} A");
    let (settled, peak, _) = brushed(f32::INFINITY, 0.0, 48.0, 4_000);
    assert!((settled - 20.0).abs() < 0.02, "{settled}");
    assert!(peak < 21.5, "{peak}");
}

#[test]
fn saturation_of_a_brushed_motor_leaves_no_windup_behind() {
    // 20 A need 8 V plus 10 V of back-EMF. A supply of 12 V cannot give that.
    let (mut current, _, mut current_loop) = brushed(20.0, 10.0, 12.0, 20_000);
    let mut volts = 11.4;
    current_loop.demand(BridgeDemand::Current(0.0), 12.0, 0.0);
    for _ in 0..60 {
        (current, volts) = after(&mut current_loop, current, volts, 10.0, 12.0);
    }
    assert!(current.abs() < 1.0, "still {current} A after 3 ms");
}

#[test]
fn a_demand_expires_after_three_control_periods() {
    for config in [BRUSHED, THREE_PHASE] {
        let mut current_loop = CurrentLoop::new(&config, &STAGE).unwrap();
        let rest = Readings::default();
        assert_eq!(current_loop.period(&rest), PowerStage::Off);
        let demand = BridgeDemand::Current(5.0);
        current_loop.demand(demand, 24.0, 0.0);
        for period in 0..60 {
            let stage = current_loop.period(&rest);
            assert_ne!(stage, PowerStage::Off, "{demand:?} {period}");
        }
        for _ in 0..1_000 {
            assert_eq!(current_loop.period(&rest), PowerStage::Off, "{demand:?}");
        }
        // After the expiry, the next demand is followed as usual.
        current_loop.demand(BridgeDemand::Current(5.0), 24.0, 0.0);
        assert_ne!(current_loop.period(&rest), PowerStage::Off);
    }
}

#[test]
fn no_sample_is_not_a_current_of_zero() {
    let mut current_loop = CurrentLoop::new(&BRUSHED, &STAGE).unwrap();
    assert_eq!(current_loop.take_means(), None);
    for amperes in [2.0, 4.0] {
        current_loop.period(&Readings {
            currents: [code(amperes), code(-amperes)],
            ..Readings::default()
        });
    }
    assert!((current_loop.take_means().unwrap().current - 3.0).abs() < 1e-3);
    assert_eq!(current_loop.take_means(), None);
}

#[test]
fn the_bridge_opens_beyond_its_currents() {
    for config in [BRUSHED, THREE_PHASE] {
        let mut current_loop = CurrentLoop::new(&config, &STAGE).unwrap();
        let mut stage = |demand, a: f64| {
            current_loop.demand(BridgeDemand::Off, 24.0, 0.0); // ends a trip
            current_loop.demand(demand, 24.0, 0.0);
            current_loop.period(&Readings {
                currents: [code(a), code(0.0)],
                ..Readings::default()
            })
        };
        for a in [29.9, -29.9] {
            assert_ne!(stage(BridgeDemand::Current(0.0), a), PowerStage::Off, "{a}");
        }
        for a in [30.1, -30.1, 40.0, -40.0] {
            assert_eq!(stage(BridgeDemand::Current(0.0), a), PowerStage::Off, "{a}");
        }
    }
}

/// A three-phase motor at a bridge that carries 50 A for ever. At 300 rad/s its back-EMF between
/// two leads is 36 V, and its shorted winding takes 28 A: 21 V at 0.4 ohm, and 0.63 and 0.84 ohm in
/// the axes d and q.
const STRONG: Config = Config {
    continuous_current: 50.0,
    ..THREE_PHASE
};

/// Stage of a drive that brakes at these supply voltages and speeds, one control period after the
/// other, with this current.
fn braking(config: &Config, steps: &[(f32, f32)], a: f64) -> Vec<PowerStage> {
    let mut current_loop = CurrentLoop::new(config, &STAGE).unwrap();
    let currents = [code(a), code(-0.5 * a)];
    let readings = Readings {
        currents,
        ..Readings::default()
    };
    let mut stages = Vec::new();
    for (supply, velocity) in steps {
        current_loop.demand(BridgeDemand::Brake, *supply, *velocity);
        let period = current_loop.period(&readings);
        for _ in 1..20 {
            assert_eq!(
                current_loop.period(&readings),
                period,
                "{supply} {velocity}"
            );
        }
        current_loop.take_means();
        stages.push(period);
    }
    stages
}

#[test]
fn a_brake_is_open_below_the_supply_and_a_lasting_short_above_it_if_the_bridge_carries_that() {
    use PowerStage::{Brake, Off};
    for side in [1.0, -1.0] {
        let at = |config: &Config, speed: f32| braking(config, &[(24.0, side * speed)], 0.0)[0];
        // 24 V at 198 rad/s.
        assert_eq!([at(&STRONG, 195.0), at(&STRONG, 201.0)], [Off, Brake]);
        // The other one carries 10 A.
        assert_eq!(at(&THREE_PHASE, 201.0), Off);
        // A brushed motor takes 79 A there.
        let brushed = Config {
            kind: MotorKind::Brushed,
            ..STRONG
        };
        assert_eq!(at(&brushed, 300.0), Off);
        // A short lasts until it takes 5 A: at 29 rad/s.
        let speeds = [300.0, 190.0, 100.0, 31.0, 27.0, 100.0];
        let steps = speeds.map(|speed| (24.0, side * speed));
        let stages = braking(&STRONG, &steps, 25.0);
        assert_eq!(stages, [Brake, Brake, Brake, Brake, Off, Off]);
    }
    assert_eq!(braking(&STRONG, &[(f32::NAN, 300.0)], 0.0), [Off]);
    assert_eq!(braking(&STRONG, &[(24.0, f32::NAN)], 0.0), [Off]);
}

#[test]
fn a_short_with_an_over_current_is_opened_once_and_for_all() {
    let mut current_loop = CurrentLoop::new(&STRONG, &STAGE).unwrap();
    let mut stages = Vec::new();
    for milliseconds in 0..3 {
        current_loop.demand(BridgeDemand::Brake, 24.0, 300.0);
        for _ in 0..20 {
            let a = if milliseconds == 1 { 31.0 } else { 0.0 };
            let currents = [code(a), code(-a)];
            stages.push(current_loop.period(&Readings {
                currents,
                ..Readings::default()
            }));
        }
        let means = current_loop.take_means().unwrap();
        assert_eq!(means.electrical.over_current, milliseconds > 0);
    }
    let opened = stages.iter().position(|stage| *stage == PowerStage::Off);
    // With the second sample.
    assert_eq!(opened, Some(21));
    assert!(stages[21..].iter().all(|stage| *stage == PowerStage::Off));
}

#[test]
fn a_converter_at_either_end_of_its_range_trips_with_any_zero_between_25_and_75_percent() {
    for config in [BRUSHED, THREE_PHASE] {
        for zero in [16_384, 24_687, 32_768, 41_000, 49_152] {
            let sensing = CurrentSensing {
                zero: [zero, 32_768],
                ..CurrentSensing::default()
            };
            // The shorter side of 32 A, divided by 150 %.
            let side = 32.0 * f64::from(zero.min(65_536 - zero)) / 32_768.0;
            let limited = |current_limit: f64| Config {
                current_limit: current_limit as f32,
                ..config
            };
            let largest = limited(side / 1.5 - 0.01);
            assert_eq!(largest.check_range(&sensing, &STAGE), Ok(()), "{zero}");
            let larger = limited(side / 1.5 + 0.01).check_range(&sensing, &STAGE);
            assert!(
                matches!(larger, Err(CurrentLoopError::CurrentTooHigh { .. })),
                "{zero}"
            );
            let stage = |first: u16| {
                let mut current_loop = CurrentLoop::new(&largest, &STAGE).unwrap();
                current_loop.set_sensing(sensing);
                current_loop.demand(BridgeDemand::Current(0.0), 24.0, 0.0);
                current_loop.period(&Readings {
                    currents: [first, 1 << 15],
                    ..Readings::default()
                })
            };
            // The ends of a converter with 12 bits.
            for end in [15, 65_535] {
                assert_eq!(stage(end), PowerStage::Off, "{zero} {end}");
            }
            let near = (0.9 * side / 32.0 * 32_768.0) as i32;
            for inside in [zero - near, zero + near] {
                assert_ne!(stage(inside as u16), PowerStage::Off, "{zero} {inside}");
            }
        }
    }
}

#[test]
fn two_over_voltages_in_a_control_period_open_the_bridge_but_no_short() {
    for config in [BRUSHED, THREE_PHASE] {
        let mut current_loop = CurrentLoop::new(&config, &STAGE).unwrap();
        let mut run = |demand, velocity, high: &[usize]| {
            current_loop.demand(demand, 24.0, velocity);
            let stages: Vec<_> = (0..20)
                .map(|period| {
                    current_loop.period(&Readings {
                        over_voltage: high.contains(&period),
                        ..Readings::default()
                    })
                })
                .collect();
            let open = stages.iter().filter(|stage| **stage == PowerStage::Off);
            let means = current_loop.take_means().unwrap().electrical;
            (open.count(), means.over_voltage, means.over_current)
        };
        let on = BridgeDemand::Current(5.0);
        assert_eq!(run(on, 0.0, &[4]), (1, false, false));
        assert_eq!(run(on, 0.0, &[4, 5]), (16, true, false));
        assert_eq!(run(on, 0.0, &[]), (20, true, false));
        // The reaction to the fault ends it, and so does a bridge that is switched off.
        assert_eq!(run(BridgeDemand::Brake, 0.0, &[]), (20, false, false));
        assert_eq!(run(on, 0.0, &[]), (0, false, false));
    }
    let short: Vec<_> = braking(&STRONG, &[(24.0, 300.0)], 0.0);
    assert_eq!(short, [PowerStage::Brake]);
    let mut current_loop = CurrentLoop::new(&STRONG, &STAGE).unwrap();
    current_loop.demand(BridgeDemand::Brake, 24.0, 300.0);
    for _ in 0..20 {
        let stage = current_loop.period(&Readings {
            over_voltage: true,
            ..Readings::default()
        });
        assert_eq!(stage, PowerStage::Brake);
    }
}

#[test]
fn two_over_currents_in_a_control_period_keep_the_bridge_open_until_it_is_switched_off() {
    for config in [BRUSHED, THREE_PHASE] {
        let mut current_loop = CurrentLoop::new(&config, &STAGE).unwrap();
        let on = BridgeDemand::Current(5.0);
        let mut run = |demand, currents: &[f64]| -> (PowerStage, bool) {
            current_loop.demand(demand, 24.0, 0.0);
            let mut stage = PowerStage::Off;
            for a in currents {
                let currents = [code(*a), code(-a)];
                stage = current_loop.period(&Readings {
                    currents,
                    ..Readings::default()
                });
            }
            let means = current_loop.take_means().unwrap();
            (stage, means.electrical.over_current)
        };
        let mut bad = [0.0; 20];
        bad[7] = 31.0;
        // One sample may be disturbed.
        for _ in 0..5 {
            let (stage, tripped) = run(on, &bad);
            assert!(stage != PowerStage::Off && !tripped);
        }
        bad[9] = -31.0;
        assert_eq!(run(on, &bad), (PowerStage::Off, true));
        assert_eq!(run(on, &[0.0; 20]), (PowerStage::Off, true));
        assert_eq!(
            run(BridgeDemand::Brake, &[0.0; 20]),
            (PowerStage::Off, true)
        );
        assert_eq!(run(BridgeDemand::Off, &[0.0; 20]), (PowerStage::Off, false));
        let (stage, tripped) = run(on, &[0.0; 20]);
        assert!(stage != PowerStage::Off && !tripped);
    }
}

#[test]
fn means_hold_the_voltage_and_say_when_periods_are_missing() {
    let mut bench = Bench::new(&THREE_PHASE, &THREE_PHASE, 500.0);
    bench.run(6.0, 2_000);
    bench.current_loop.take_means();
    bench.run(6.0, 20);
    let means = bench.current_loop.take_means().unwrap();
    let [d, q] = means.electrical.voltage.unwrap();
    // V = R i + w L i, and the back-EMF.
    let expected_d = -500.0 * f64::from(THREE_PHASE.inductance[1]) * 6.0;
    let expected_q = f64::from(THREE_PHASE.resistance) * 6.0 + 500.0 * flux(&THREE_PHASE);
    assert!((f64::from(d) - expected_d).abs() < 0.05, "{d} {expected_d}");
    assert!((f64::from(q) - expected_q).abs() < 0.05, "{q} {expected_q}");
    assert!((means.current - 6.0).abs() < 0.05 && means.electrical.direct.abs() < 0.05);
    for (periods, overrun) in [(9, true), (10, false), (20, false), (40, false), (41, true)] {
        bench.run(6.0, periods);
        let means = bench.current_loop.take_means().unwrap();
        assert_eq!(means.electrical.overrun, overrun, "{periods} periods");
    }
}

#[test]
fn a_current_in_d_burns_power_and_leaves_the_torque() {
    let mut bench = Bench::new(&THREE_PHASE, &THREE_PHASE, 300.0);
    for period in 0..2_000 {
        if period % 20 == 0 {
            let demand = BridgeDemand::Braking {
                current: -5.0,
                direct: -30.0,
            };
            let shaft = bench.speed / f64::from(MOUNTING.pole_pairs);
            bench.current_loop.demand(demand, 24.0, shaft as f32);
        }
        bench.period();
    }
    let [d, q] = bench.current;
    assert!((q + 5.0).abs() < 0.15, "{q}");
    // What the current in q leaves of 20 A.
    assert!((d + (400.0_f64 - 25.0).sqrt()).abs() < 0.15, "{d}");
}

#[test]
fn without_a_usable_supply_all_half_bridges_give_the_same_voltage() {
    for config in [BRUSHED, THREE_PHASE] {
        for supply in [0.0, 4.9, -24.0, f32::NAN, f32::INFINITY] {
            let mut current_loop = CurrentLoop::new(&config, &STAGE).unwrap();
            current_loop.demand(BridgeDemand::Current(9.0), supply, 3.0);
            for rotor in 0..50 {
                let [a, b, c] = compare(current_loop.period(&Readings {
                    rotor,
                    ..Readings::default()
                }));
                assert!(a == b && b == c, "{supply}: {a} {b} {c}");
            }
        }
    }
}

#[test]
fn refuses_what_it_cannot_control() {
    let error = |config: Config| CurrentLoop::new(&config, &STAGE).err().unwrap();
    let not_positive = |name| move |error| matches!(error, CurrentLoopError::NotPositive { name: got, .. } if got == name);
    let dead = Config {
        inductance: [0.0, 3e-4],
        ..THREE_PHASE
    };
    assert!(not_positive("inductance")(error(dead)));
    let no_number = Config {
        bandwidth: f32::NAN,
        ..THREE_PHASE
    };
    assert!(not_positive("bandwidth")(error(no_number)));
    let fast = Config {
        bandwidth: 5_001.0,
        ..BRUSHED
    };
    let slow_winding = Config {
        inductance: [0.1; 2],
        ..THREE_PHASE
    };
    let strong = Config {
        current_limit: 22.0,
        ..THREE_PHASE
    };
    let slow_bridge = Config {
        dead_time: 1.1e-6,
        ..THREE_PHASE
    };
    let wrong_counts = Config {
        sensor: RotorSensor::Halls,
        ..THREE_PHASE
    };
    for (config, text) in [
        (
            fast,
            "bandwidth = 5001 rad/s, at most 5000 at this PWM rate",
        ),
        (
            slow_winding,
            "bandwidth times inductance = 200, at most 32 on this board",
        ),
        (
            strong,
            "current limit = 22 A, at most 21.333334 A on this board",
        ),
        (slow_bridge, "dead time = 0.0000011 s, at most 0.000001 s"),
        (
            wrong_counts,
            "encoder_counts = 4096, 2688 with Hall sensors",
        ),
    ] {
        assert_eq!(error(config).to_string(), text);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_command_leaves_the_period_and_no_current_its_limit(
        three_phase in any::<bool>(),
        dead_time in 0.0_f32..1e-6,
        steps in proptest::collection::vec(
            (any::<[u16; 2]>(), any::<u32>(), any::<f32>(), any::<f32>(), any::<f32>()), 1..50),
    ) {
        let config = Config { dead_time, ..if three_phase { THREE_PHASE } else { BRUSHED } };
        let mut current_loop = CurrentLoop::new(&config, &STAGE).unwrap();
        for (currents, rotor, demand, supply, velocity) in steps {
            current_loop.demand(BridgeDemand::Current(demand), supply, velocity);
            let beyond = |a: f64| a.abs() > 30.01;
            let [a, b] = currents.map(amperes);
            let off = beyond(a) || three_phase && (beyond(b) || beyond(a + b));
            match current_loop.period(&Readings { currents, rotor, ..Readings::default() }) {
                PowerStage::Drive(counts) => {
                    prop_assert!(!off, "{a} {b}");
                    prop_assert!(counts.iter().all(|count| *count <= STAGE.period), "{counts:?}");
                }
                stage => prop_assert_eq!(stage, PowerStage::Off),
            }
            prop_assert!(current_loop.take_means().unwrap().current.is_finite());
        }
    }
}

#[test]
fn the_third_converter_has_a_zero_of_its_own() {
    let mut current_loop = CurrentLoop::new(&THREE_PHASE, &STAGE).unwrap();
    let mut run = |demand, sum: f64| {
        let mut electrical = None;
        for _ in 0..100 {
            for _ in 0..20 {
                current_loop.demand(demand, 24.0, 0.0);
                current_loop.period(&Readings {
                    third: Some(code(3.0 + sum)),
                    ..Readings::default()
                });
            }
            electrical = Some(current_loop.take_means().unwrap().electrical);
        }
        let electrical = electrical.unwrap();
        electrical.wrong_sum || electrical.wrong_zero
    };
    assert!(!run(BridgeDemand::Off, 0.0));
    assert!(!run(BridgeDemand::Current(1.0), 4.5));
    assert!(!run(BridgeDemand::Current(1.0), -4.5));
    assert!(run(BridgeDemand::Current(1.0), 4.8));
}

#[test]
fn currents_that_do_not_add_up_to_0_are_found() {
    for (config, third) in [
        (BRUSHED, None),
        (THREE_PHASE, Some(0.0)),
        (THREE_PHASE, None),
    ] {
        let mut current_loop = CurrentLoop::new(&config, &STAGE).unwrap();
        let mut run = |a: f64, b: f64| {
            for _ in 0..20 {
                current_loop.demand(BridgeDemand::Current(1.0), 24.0, 0.0);
                current_loop.period(&Readings {
                    currents: [code(a), code(b)],
                    third: third.map(|c: f64| code(c)),
                    ..Readings::default()
                });
            }
            current_loop.take_means().unwrap().electrical.wrong_sum
        };
        // 20 % of 20 A, and 2 % of 32 A.
        assert!(!run(8.0, -8.0) && !run(8.0, -3.5));
        let checked = third.is_some() || config.kind == MotorKind::Brushed;
        assert_eq!(run(8.0, -3.2), checked, "{:?} {third:?}", config.kind);
        assert_eq!(run(0.0, -6.0), checked, "{:?} {third:?}", config.kind);
    }
}
