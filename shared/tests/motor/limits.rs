//! Compares the current limiter with the power balance of a motor in double precision.

use proptest::prelude::*;
use tautrack::motor::limits::{ActiveLimit, Conditions, Limited, Limiter};
use tautrack::sensors::Temperatures;
use tautrack::settings::{Setting, Settings, TABLE};

const QUIET: Conditions = Conditions {
    current: 0.0,
    supply_voltage: 24.0,
    voltage: 0.0,
    velocity: 0.0,
    temperatures: Temperatures {
        bridge: None,
        motor: None,
    },
};
/// Current limit, A, of the default settings.
const PEAK: f32 = 10.0;

fn settings(changes: &[(Setting, i32)]) -> Settings {
    let mut settings = Settings::default();
    for (setting, value) in changes {
        settings.set(setting.description().key, *value).unwrap();
    }
    settings
}

/// A limiter whose parts have cooled down.
fn cold(changes: &[(Setting, i32)]) -> Limiter {
    let mut limiter = Limiter::new(&settings(changes));
    for _ in 0..300_000 {
        limiter.idle(0.0);
    }
    limiter
}

fn once(changes: &[(Setting, i32)], demand: f32, now: &Conditions) -> Limited {
    Limiter::new(&settings(changes)).limit(demand, PEAK, now)
}

#[test]
fn nothing_is_limited_with_the_default_settings() {
    let mut limiter = Limiter::new(&Settings::default());
    for velocity in [-6.5, -3.0, 0.0, 1e-3, 6.5] {
        for voltage in [14.1, 24.0, 29.9] {
            for demand in [-10.0, -3.3, 0.0, 7.7, 10.0] {
                let now = Conditions {
                    velocity,
                    supply_voltage: voltage,
                    current: demand,
                    ..QUIET
                };
                let limited = limiter.limit(demand, PEAK, &now);
                let expected = Limited {
                    current: demand,
                    direct: 0.0,
                    cause: ActiveLimit::None,
                };
                assert_eq!(limited, expected, "{velocity} rad/s, {voltage} V");
            }
        }
    }
}

/// Settings, demand, readings, and the limit that must act.
type Case<'a> = (&'a [(Setting, i32)], f32, Conditions, ActiveLimit);

#[test]
fn each_limit_is_reported_by_its_name() {
    let fast = Conditions {
        velocity: 5.0,
        ..QUIET
    };
    let volts = |supply_voltage| Conditions {
        supply_voltage,
        ..fast
    };
    let degrees = |bridge, motor| Conditions {
        temperatures: Temperatures { bridge, motor },
        ..QUIET
    };
    let hot = [
        (Setting::BridgeTemperature, 900),
        (Setting::MotorTemperature, 1_200),
    ];
    let cases: &[Case] = &[
        (
            &[(Setting::SupplyCurrentLimit, 2_000)],
            9.0,
            fast,
            ActiveLimit::SupplyCurrent,
        ),
        (
            &[(Setting::RegenerationCurrentLimit, 0)],
            -9.0,
            fast,
            ActiveLimit::RegenerationCurrent,
        ),
        (&[], 9.0, volts(12.1), ActiveLimit::LowSupplyVoltage),
        (&[], -9.0, volts(32.1), ActiveLimit::HighSupplyVoltage),
        (&[(Setting::PowerLimit, 50)], 9.0, fast, ActiveLimit::Power),
        (
            &[],
            9.0,
            Conditions {
                velocity: 7.0,
                ..QUIET
            },
            ActiveLimit::Speed,
        ),
        (
            &[(Setting::CurrentSlope, 1_000)],
            9.0,
            QUIET,
            ActiveLimit::CurrentSlope,
        ),
        // 9.6 V of back-EMF.
        (
            &[(Setting::MotorKind, 1)],
            9.0,
            Conditions {
                velocity: 6.0,
                supply_voltage: 20.0,
                ..QUIET
            },
            ActiveLimit::Voltage,
        ),
        (
            &[(Setting::WindingCurrent, 4_000)],
            9.0,
            QUIET,
            ActiveLimit::WindingHeat,
        ),
        (
            &[(Setting::BridgeCurrent, 4_000)],
            9.0,
            QUIET,
            ActiveLimit::BridgeHeat,
        ),
        (
            &hot,
            9.0,
            degrees(Some(85.0), Some(20.0)),
            ActiveLimit::BridgeTemperature,
        ),
        (
            &hot,
            9.0,
            degrees(Some(20.0), Some(115.0)),
            ActiveLimit::MotorTemperature,
        ),
    ];
    for (changes, demand, now, cause) in cases {
        let limited = once(changes, *demand, now);
        assert_eq!(limited.cause, *cause);
        assert!(
            limited.current.abs() < demand.abs(),
            "{cause:?} {limited:?}"
        );
    }
    // A missing sensor allows no current.
    assert_eq!(
        once(&hot, 9.0, &degrees(Some(f32::NAN), Some(20.0))).current,
        0.0
    );
    assert_eq!(once(&hot, 9.0, &QUIET).current, 0.0);
}

#[test]
fn braking_is_not_limited_by_speed_and_ends_at_standstill_at_any_supply_voltage() {
    for velocity in [6.9, 7.3, 20.0] {
        let now = Conditions { velocity, ..QUIET };
        assert_eq!(once(&[], -10.0, &now).current, -10.0);
        if velocity > 7.2 {
            assert_eq!(once(&[], 10.0, &now).current, 0.0);
        }
    }
    for motor in [0, 1] {
        for supply_voltage in [5.0, 11.0, 24.0, 31.0, 40.0] {
            let (mut velocity, mut milliseconds) = (7.0_f32, 0);
            let mut limiter = Limiter::new(&settings(&[(Setting::MotorKind, motor)]));
            while velocity > 0.05 {
                let now = Conditions {
                    velocity,
                    supply_voltage,
                    ..QUIET
                };
                let current = limiter.limit(-10.0, PEAK, &now).current;
                assert!(current < 0.0, "{motor} {supply_voltage} V {velocity}");
                velocity += 2.4 * current * 1e-3 / 0.5;
                milliseconds += 1;
            }
            println!("motor {motor}, {supply_voltage} V: {milliseconds} ms");
            assert!(milliseconds < 1_000, "{motor} {supply_voltage}");
        }
    }
}

#[test]
fn the_heat_of_an_overload_is_that_of_a_first_order_body() {
    // 8 A in a winding of 4 A: the heat 1 - 0.1 is reached after tau ln(4 / (4 - 0.9)).
    let mut limiter = cold(&[
        (Setting::WindingCurrent, 4_000),
        (Setting::WindingTime, 20_000),
    ]);
    let (mut current, mut milliseconds) = (0.0, 0);
    let limited = loop {
        let limited = limiter.limit(8.0, PEAK, &Conditions { current, ..QUIET });
        current = limited.current;
        milliseconds += 1;
        if limited.cause != ActiveLimit::None {
            break limited;
        }
    };
    assert_eq!(limited.cause, ActiveLimit::WindingHeat);
    // From 10 A to 4 A in the last tenth: 8 A are cut at 1 - 2/3 of it.
    let level = 0.9 + 0.1 / 3.0;
    let expected = 20_000.0 * (4.0_f64 / (4.0 - level)).ln();
    assert!(
        (f64::from(milliseconds) / expected - 1.0).abs() < 0.01,
        "{milliseconds} {expected}"
    );
    for _ in 0..200_000 {
        current = limiter
            .limit(8.0, PEAK, &Conditions { current, ..QUIET })
            .current;
        assert!(limiter.heat()[0] <= 1_000);
    }
    assert!((current - 4.0).abs() < 0.05, "{current}");
}

#[test]
fn a_current_changes_no_faster_than_its_slope() {
    let mut limiter = cold(&[(Setting::CurrentSlope, 500)]);
    let mut before = 0.0_f32;
    for tick in 0..200 {
        let demand = if tick % 60 < 30 { 9.0 } else { -9.0 };
        let current = limiter.limit(demand, PEAK, &QUIET).current;
        assert!((current - before).abs() < 0.500_01, "{before} {current}");
        before = current;
    }
}

#[test]
fn a_bound_that_is_no_current_ends_the_current_at_once() {
    for bound in [f32::NAN, -1.0, 0.0, -0.0, f32::NEG_INFINITY] {
        let mut limiter = cold(&[(Setting::CurrentSlope, 500)]);
        limiter.limit(9.0, PEAK, &QUIET);
        let before = limiter.limit(9.0, PEAK, &QUIET).current;
        assert!(before > 0.5, "{before}");
        let limited = limiter.limit(9.0, bound, &QUIET);
        assert_eq!([limited.current, limited.direct], [0.0; 2], "{bound}");
    }
}

#[test]
fn the_voltage_of_a_braking_motor_suffices_beside_the_current_that_weakens_its_field() {
    let (emf, pairs, gear) = (0.04 / 1.5 * 60.0, 7.0, 60.0);
    let (mut weakened, mut reduced) = (0, 0);
    for inductance in [50, 150, 300] {
        for resistance in [100, 300, 600] {
            for tenths in 0..=70 {
                for demand in [-0.1, -2.0, -5.0, -10.0] {
                    let changes = [
                        (Setting::MotorKind, 1),
                        (Setting::PolePairs, 7),
                        (Setting::Inductance, inductance),
                        (Setting::InductanceQ, 2 * inductance),
                        (Setting::Resistance, resistance),
                    ];
                    let velocity = f64::from(tenths) * 0.1;
                    let now = Conditions {
                        velocity: velocity as f32,
                        supply_voltage: 15.0,
                        ..QUIET
                    };
                    let limited = once(&changes, demand, &now);
                    let [q, d] = [limited.current, limited.direct].map(f64::from);
                    let reactance = velocity * gear * pairs * f64::from(inductance) * 1e-6;
                    let ohms = f64::from(resistance) * 1e-3;
                    let voltage =
                        (velocity * emf + ohms * q + reactance * d).hypot(2.0 * reactance * q);
                    let largest = 0.95 * 0.95 * 15.0 / 3.0_f64.sqrt();
                    weakened += usize::from(d < 0.0);
                    reduced += usize::from(limited.cause == ActiveLimit::Voltage);
                    let full = q.hypot(d) > 9.99;
                    assert!(q.hypot(d) < 10.001);
                    assert!(
                        full || voltage < largest * 1.001,
                        "{voltage} V {limited:?} {inductance} uH {ohms} ohm {velocity} rad/s"
                    );
                    // No more than necessary.
                    assert!(
                        d == 0.0 || full || voltage > largest * 0.97,
                        "{voltage} {limited:?}"
                    );
                }
            }
        }
    }
    println!("{weakened} {reduced}");
    assert!(weakened > 500 && reduced > 100);
}

/// Any settings of the limits, and of the motor within the range of real motors.
fn any_settings() -> impl Strategy<Value = Settings> {
    let limits = TABLE
        .iter()
        .filter(|row| (0x00d0..=0x00df).contains(&row.key))
        .map(|row| {
            let key = row.key;
            prop_oneof![
                2 => Just(row.default),
                1 => row.minimum..=row.maximum,
                1 => row.minimum..=row.minimum.saturating_add(50).min(row.maximum),
            ]
            .prop_map(move |value| (key, value))
        })
        .collect::<Vec<_>>();
    let motor = (
        0..=1_i32,
        1_000..200_000_i32,
        1_000..100_000_i32,
        10..5_000_i32,
        10..1_000_i32,
        0..=20_000_i32,
    );
    (limits, motor).prop_map(
        |(limits, (kind, gear, constant, resistance, inductance, weakening))| {
            let mut settings = settings(&[
                (Setting::MotorKind, kind),
                (Setting::GearRatio, gear),
                (Setting::TorqueConstant, constant),
                (Setting::Resistance, resistance),
                (Setting::Inductance, inductance),
                (Setting::FieldWeakeningCurrent, weakening),
            ]);
            for (key, value) in limits {
                settings.set(key, value).unwrap();
            }
            settings
        },
    )
}

fn any_f32() -> impl Strategy<Value = f32> {
    prop_oneof![2 => -20.0_f32..40.0, 1 => any::<u32>().prop_map(f32::from_bits)]
}

fn conditions() -> impl Strategy<Value = Conditions> {
    let temperature = || proptest::option::of(any_f32());
    (
        any_f32(),
        any_f32(),
        any_f32(),
        any_f32(),
        temperature(),
        temperature(),
    )
        .prop_map(
            |(current, supply_voltage, voltage, velocity, bridge, motor)| Conditions {
                current,
                supply_voltage,
                voltage,
                velocity,
                temperatures: Temperatures { bridge, motor },
            },
        )
}

/// Power that a supply may give or take at `voltage`: `sign` is 1 or -1.
fn allowed_power(settings: &Settings, voltage: f64, sign: f64) -> f64 {
    let get = |setting| f64::from(settings.get(setting)) * 1e-3;
    let (limit, from, to) = if sign > 0.0 {
        (
            Setting::SupplyCurrentLimit,
            Setting::MotoringVoltage,
            Setting::UnderVoltage,
        )
    } else {
        (
            Setting::RegenerationCurrentLimit,
            Setting::RegenerationVoltage,
            Setting::OverVoltage,
        )
    };
    let width = (get(from) - get(to)) * sign;
    let inside = (voltage - get(to)) * sign;
    let part = if width > 0.0 {
        (inside / width).clamp(0.0, 1.0)
    } else {
        f64::from(inside > 0.0)
    };
    (voltage * get(limit) * part).clamp(0.0, f64::from(settings.get(Setting::PowerLimit)))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_current_exceeds_any_limit(
        settings in any_settings(),
        steps in proptest::collection::vec((any_f32(), any_f32(), any_f32(), conditions()), 1..8),
    ) {
        let mut limiter = Limiter::new(&settings);
        let three_phase = settings.get(Setting::MotorKind) == 1;
        let scaled = |setting, scale: f64| f64::from(settings.get(setting)) * scale;
        let emf_constant = scaled(Setting::TorqueConstant, 1e-6) * scaled(Setting::GearRatio, 1e-3);
        let loss = scaled(Setting::Resistance, 1e-3) * if three_phase { 1.5 } else { 1.0 };
        for (demand, wanted, bound, now) in steps {
            let mut limited = limiter.limit(demand, bound, &now);
            if three_phase && limited.direct == 0.0 {
                limited.direct = limiter.add_direct(wanted, bound, &now);
            }
            let (current, direct) = (f64::from(limited.current), f64::from(limited.direct));
            prop_assert!(current.is_finite() && direct.is_finite());
            let peak = if bound > 0.0 { f64::from(bound) } else { 0.0 };
            prop_assert!(current.hypot(direct) <= peak * 1.000_001 + 1e-9, "{limited:?} {bound}");
            // Temperatures.
            for (setting, reading) in [
                (Setting::BridgeTemperature, now.temperatures.bridge),
                (Setting::MotorTemperature, now.temperatures.motor),
            ] {
                let end = scaled(setting, 0.1);
                let celsius = reading.map_or(f64::NAN, f64::from);
                prop_assert!(end == 0.0 || celsius < end || current == 0.0, "{celsius} {end}");
            }
            let (velocity, voltage) = (f64::from(now.velocity), f64::from(now.supply_voltage));
            if !velocity.is_finite() || !voltage.is_finite() {
                continue;
            }
            let along = velocity * current >= 0.0;
            if along && velocity.abs() > 1.2 * 6.0 + 1e-3 {
                prop_assert_eq!(current, 0.0);
            }
            // Power at the terminals; the tolerance is that of single precision.
            let mechanical = emf_constant * velocity * current;
            let power = mechanical + loss * (current * current + direct * direct);
            let tolerance = 1e-4 * (mechanical.abs() + loss * peak * peak) + 1e-6;
            let most = allowed_power(&settings, voltage, 1.0);
            prop_assert!(power <= most + tolerance, "{power} W > {most} W: {limited:?}");
            let most = allowed_power(&settings, voltage, -1.0);
            let most = if three_phase { most } else { most.max(loss * peak * peak) };
            prop_assert!(-power <= most + tolerance, "{power} W < -{most} W: {limited:?}");
        }
    }
}
