//! Compares field-oriented control with double precision and with a simulated motor.

use proptest::prelude::*;
use std::f64::consts::TAU;
use tautrack::motor::foc::{Config, Dq, ElectricalAngle, Foc, FocError};
use tautrack::units::Angle;

const PERIOD: u32 = 4_250;
const CONFIG: Config = Config {
    resistance: 0.4,
    inductance: 3e-4,
    supply_voltage: 24.0,
    current_full_scale: 20.0,
    bandwidth: 2_000.0,
    rate_hz: 20_000.0,
    period: PERIOD,
};
const ONE: f64 = (1 << 30) as f64;

fn turned(vector: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [
        vector[0] * cos - vector[1] * sin,
        vector[0] * sin + vector[1] * cos,
    ]
}

fn bits(angle: f64) -> ElectricalAngle {
    ElectricalAngle(Angle::from_bits(
        (angle / TAU * 4_294_967_296.0) as i64 as i32,
    ))
}

/// Returns the currents of phases a and b, A, for a vector in the rotor's axes.
fn phases(dq: [f64; 2], angle: f64) -> [f64; 2] {
    let [alpha, beta] = turned(dq, angle);
    [alpha, -0.5 * alpha + 0.75_f64.sqrt() * beta]
}

fn q30(amperes: f64) -> i32 {
    (amperes / f64::from(CONFIG.current_full_scale) * ONE) as i32
}

/// Returns the voltage vector in the rotor's axes that three compare values make at `angle`, and
/// how far their range is off the middle, counts.
fn voltage(counts: [u16; 3], angle: f64) -> ([f64; 2], f64) {
    let [a, b, c] =
        counts.map(|count| f64::from(count) / f64::from(PERIOD) * f64::from(CONFIG.supply_voltage));
    let stator = [(2.0 * a - b - c) / 3.0, (b - c) / 3.0_f64.sqrt()];
    let (low, high) = (counts.iter().min().unwrap(), counts.iter().max().unwrap());
    (
        turned(stator, -angle),
        f64::from(*low) + f64::from(*high) - f64::from(PERIOD),
    )
}

/// Runs the same controller in double precision, in volts and amperes.
fn reference(integral: &mut [f64; 2], current: [f64; 2], demand: [f64; 2]) -> [f64; 2] {
    let limit = f64::from(CONFIG.supply_voltage) / 3.0_f64.sqrt();
    let (kp, ki) = (
        f64::from(CONFIG.bandwidth * CONFIG.inductance),
        f64::from(CONFIG.bandwidth) * f64::from(CONFIG.resistance) / f64::from(CONFIG.rate_hz),
    );
    [0, 1].map(|axis| {
        let error = demand[axis] - current[axis];
        let next = (integral[axis] + ki * error).clamp(-limit, limit);
        let wanted = kp * error + next;
        if wanted.abs() <= limit {
            integral[axis] = next;
        }
        wanted.clamp(-limit, limit)
    })
}

#[test]
fn a_step_is_that_of_double_precision_to_one_count() {
    let mut foc = Foc::new(&CONFIG).unwrap();
    let mut integral = [0.0; 2];
    let count = f64::from(CONFIG.supply_voltage) / f64::from(PERIOD);
    let (mut worst, mut compared) = (0.0_f64, 0);
    for step in 0..200_000_u32 {
        let t = f64::from(step);
        let angle = (t * 0.037).rem_euclid(TAU);
        let demand = [2.0 * (t * 1e-3).sin(), 5.0 * (t * 1.7e-3).cos()];
        let current = [
            demand[0] + 2.5 * (t * 0.01).sin(),
            demand[1] + 3.0 * (t * 0.013).cos(),
        ];
        let expected = reference(&mut integral, current, demand);
        let counts = foc.step(
            bits(angle),
            phases(current, angle).map(q30),
            Dq {
                d: q30(demand[0]),
                q: q30(demand[1]),
            },
        );
        let (got, off) = voltage(counts, angle);
        // Beyond the inner circle of the hexagon the bridge cannot follow. The next test covers
        // that.
        if expected[0].hypot(expected[1]) < f64::from(CONFIG.supply_voltage) / 3.0_f64.sqrt() {
            let error = (got[0] - expected[0]).hypot(got[1] - expected[1]) / count;
            worst = worst.max(error);
            compared += 1;
            assert!(off.abs() <= 2.0, "step {step}: {counts:?} are not centred");
        }
    }
    println!("worst error {worst} counts in {compared} steps");
    assert!(
        worst <= 1.0 && compared > 100_000,
        "{worst} counts, {compared} compared"
    );
}

/// Simulates a surface-magnet motor with the controller and one period of delay (dq equations,
/// Euler steps of a fiftieth of a period). Returns the currents of each period.
fn run(
    foc: &mut Foc,
    demand: [f64; 2],
    speed: f64,
    start: [f64; 2],
    periods: usize,
) -> Vec<[f64; 2]> {
    let (r, l, flux) = (
        f64::from(CONFIG.resistance),
        f64::from(CONFIG.inductance),
        0.01,
    );
    let (mut current, mut angle, mut applied) = (start, 0.3_f64, [PERIOD as u16 / 2; 3]);
    let demand = Dq {
        d: q30(demand[0]),
        q: q30(demand[1]),
    };
    let dt = 1.0 / f64::from(CONFIG.rate_hz) / 50.0;
    (0..periods)
        .map(|_| {
            let next = foc.step(bits(angle), phases(current, angle).map(q30), demand);
            for _ in 0..50 {
                let ([ud, uq], _) = voltage(applied, angle);
                let [d, q] = current;
                current = [
                    d + (ud - r * d + speed * l * q) / l * dt,
                    q + (uq - r * q - speed * (l * d + flux)) / l * dt,
                ];
                angle += speed * dt;
            }
            applied = next;
            current
        })
        .collect()
}

#[test]
fn currents_settle_on_the_demand_at_any_speed() {
    for speed in [0.0, 300.0, -700.0] {
        let mut foc = Foc::new(&CONFIG).unwrap();
        let history = run(&mut foc, [-1.0, 5.0], speed, [0.0; 2], 4_000);
        let [d, q] = history[3_999];
        assert!(
            (d + 1.0).abs() < 0.03 && (q - 5.0).abs() < 0.03,
            "speed {speed}: {d} {q}"
        );
        let peak = history.iter().fold(0.0_f64, |peak, [_, q]| peak.max(*q));
        // The motor is switched on at speed. Its back-EMF of 10 mV s alone drives a current until
        // the integral compensates it.
        let own = 0.01 * speed.abs() / f64::from(CONFIG.bandwidth * CONFIG.inductance);
        assert!(peak < 5.0 * 1.25 + own, "speed {speed}: peak {peak}");
    }
}

#[test]
fn saturation_leaves_no_windup_behind() {
    let mut foc = Foc::new(&CONFIG).unwrap();
    // 14 V of back-EMF: the bridge cannot drive 15 A against it.
    let stalled = run(&mut foc, [0.0, 15.0], 1_400.0, [0.0; 2], 20_000);
    assert!(stalled[19_999][1] < 14.0);
    let after = run(&mut foc, [0.0, 0.0], 0.0, [0.0; 2], 400);
    // 100 periods are 5 ms: ten time constants of the loop.
    assert!(
        after[100..].iter().all(|[_, q]| q.abs() < 1.0),
        "{:?}",
        after[100]
    );
}

#[test]
fn refuses_what_it_cannot_express() {
    let too_fast = Config {
        bandwidth: 6_000.0,
        ..CONFIG
    };
    assert_eq!(Foc::new(&too_fast).err(), Some(FocError::OutOfRange));
    let no_number = Config {
        inductance: f32::NAN,
        ..CONFIG
    };
    assert_eq!(Foc::new(&no_number).err(), Some(FocError::OutOfRange));
    let slow_winding = Config {
        inductance: 0.1,
        ..CONFIG
    };
    assert!(matches!(
        Foc::new(&slow_winding),
        Err(FocError::GainTooLarge { .. })
    ));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn compare_values_never_leave_the_period(steps in proptest::collection::vec(any::<[i32; 5]>(), 1..50)) {
        let mut foc = Foc::new(&CONFIG).unwrap();
        for [angle, a, b, d, q] in steps {
            let counts = foc.step(ElectricalAngle(Angle::from_bits(angle)), [a, b], Dq { d, q });
            prop_assert!(counts.iter().all(|count| u32::from(*count) <= PERIOD), "{counts:?}");
        }
    }
}
