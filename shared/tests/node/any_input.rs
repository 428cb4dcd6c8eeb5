//! Tests that no input makes the ticks of axle and screw exceed the current limit or panic.

use proptest::collection::vec;
use proptest::prelude::*;
use tautrack::bus::pdo::DriveMotion;
use tautrack::motor::current::Electrical;
use tautrack::motor::index::Finding;
use tautrack::motor::rotor::ElectricalAngle;
use tautrack::node::axle::{Axle, BridgeDemand, Inputs, Outputs, SetPoint};
use tautrack::node::screw::{self, Screw};
use tautrack::sensors::{Switches, Temperatures};
use tautrack::settings::{Setting, Settings};
use tautrack::units::Angle;

/// Generates any bit pattern, including NaN, infinities and subnormals.
fn any_f32() -> impl Strategy<Value = f32> {
    any::<u32>().prop_map(f32::from_bits)
}

/// Generates set-points with any target and mode that often lead to operation.
fn set_point() -> impl Strategy<Value = Option<SetPoint>> {
    let word = prop_oneof![
        Just(0x06),
        Just(0x07),
        Just(0x0f),
        Just(0x1f),
        Just(0x10f),
        Just(0x80),
        any::<u16>()
    ];
    let mode = prop_oneof![
        Just(-2_i8),
        Just(-1),
        Just(1),
        Just(3),
        Just(6),
        Just(8),
        Just(9),
        Just(10),
        any::<i8>()
    ];
    proptest::option::of(
        (word, mode, any::<i32>()).prop_map(|(controlword, mode, target)| SetPoint {
            controlword,
            mode,
            target,
        }),
    )
}

prop_compose! {
    fn electrical()(
        voltage in proptest::option::of((any_f32(), any_f32())),
        [direct, direct_size] in [any_f32(), any_f32()],
        ahead in any::<Option<i32>>(),
        index in prop_oneof![Just(Finding::Nothing), Just(Finding::Confirmed), Just(Finding::Misaligned), Just(Finding::Lost)],
        [over_current, wrong_zero, overrun, wrong_sum] in prop_oneof![9 => Just([false; 4]), 1 => any::<[bool; 4]>()],
    ) -> Electrical {
        let ahead = ahead.map(|bits| ElectricalAngle(Angle::from_bits(bits)));
        Electrical { voltage: voltage.map(|(d, q)| [d, q]), direct, direct_size, angle: ahead, ahead, index, over_current, over_voltage: false, wrong_zero, wrong_sum, overrun }
    }
}

prop_compose! {
    fn inputs()(
        jump_us in prop_oneof![Just(1_000_u64), 0..1_000_000_u64],
        (encoder, encoder_broken) in (any::<i32>(), proptest::bool::weighted(0.01)),
        current in prop_oneof![-12.0..12.0_f32, any_f32()],
        supply_voltage in prop_oneof![Just(24.0_f32), 10.0..34.0_f32, any_f32()],
        electrical in electrical(),
        temperatures in proptest::option::of((-50.0..150.0_f32, any_f32())),
        switches in any::<[bool; 3]>(),
        set_point in set_point(),
        torque_offset in any::<Option<i16>>(),
        guard_received in any::<bool>(),
        bench_mode in any::<bool>(),
    ) -> Inputs {
        let [home, positive_limit, negative_limit] = switches;
        let switches = Switches { home, positive_limit, negative_limit };
        // `now_us` is a step of time here. The caller adds the steps up.
        Inputs {
            now_us: jump_us,
            encoder,
            encoder_broken,
            bridge_stop: None,
            current,
            electrical,
            supply_voltage,
            temperatures: Temperatures { bridge: temperatures.map(|(bridge, _)| bridge), motor: temperatures.map(|(_, motor)| motor) },
            switches,
            set_point,
            torque_offset,
            guard_received,
            bench_mode,
        }
    }
}

fn within_limit(outputs: &Outputs, limit: f32) -> bool {
    match outputs.bridge {
        BridgeDemand::Current(current) | BridgeDemand::Align { current, .. } => {
            current.abs() <= limit
        }
        BridgeDemand::Braking { current, direct } => current.hypot(direct) <= limit * 1.000_001,
        BridgeDemand::Off | BridgeDemand::Brake | BridgeDemand::Aligned(_) => true,
    }
}

proptest! {
    #[test]
    fn no_input_makes_an_axle_ask_for_more_than_its_current_limit(
        steps in vec(inputs(), 1..200),
        homed in any::<bool>(),
        three_phase in any::<bool>(),
        rotor_sensor in 0..=5,
    ) {
        let mut settings = Settings::default();
        for (setting, value) in [
            (Setting::MotorKind, three_phase.into()),
            (Setting::RotorSensor, rotor_sensor),
            (Setting::HomingDirection, (!homed).into()),
        ] {
            settings.set(setting.description().key, value).unwrap();
        }
        let mut axle = Axle::new(&settings);
        let mut now_us = 0_u64;
        for step in steps {
            now_us = now_us.saturating_add(step.now_us);
            let outputs = axle.tick(&Inputs { now_us, ..step });
            prop_assert!(within_limit(&outputs, 10.0), "{outputs:?}");
        }
    }

    #[test]
    fn no_input_makes_a_screw_ask_for_more_than_its_current_limit(
        steps in vec((inputs(), any::<[i32; 2]>(), any::<bool>(), any::<u64>()), 1..200),
    ) {
        let mut screw = Screw::new(&Settings::default()).unwrap();
        let mut now_us = 0_u64;
        for (axle, [position, velocity], received, stamp) in steps {
            now_us = now_us.saturating_add(axle.now_us);
            let measured_us = if stamp % 4 == 0 { stamp } else { now_us };
            let joint = received.then_some((DriveMotion { position, velocity }, measured_us));
            let outputs = screw.tick(&screw::Inputs { axle: Inputs { now_us, ..axle }, joint });
            prop_assert!(within_limit(&outputs, 10.0), "{outputs:?}");
        }
    }
}
