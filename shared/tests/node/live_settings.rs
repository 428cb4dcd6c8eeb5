//! Settings that a drive uses as soon as a client has written them.

use super::wire::{Wire, set_point};
use proptest::collection::vec;
use proptest::prelude::*;
use tautrack::bus::cia402::{State, mode, toward_operation};
use tautrack::faults::Fault;
use tautrack::node::axle::BridgeDemand;
use tautrack::settings::{Effect, Setting, Settings};

const DEVICE_STATE: u32 = 0x0800_0022;
const TOO_HIGH: u32 = 0x0609_0031;
const TOO_LOW: u32 = 0x0609_0032;
/// The boards of these tests measure 40 A, and so 150 % of this, mA.
const LARGEST_CURRENT: i32 = 26_666;
/// They bear 36 V, 110 % of the back-EMF of 0.04 N m/A and a gear of 60 at 120 % of this, mrad/s.
const LARGEST_VELOCITY: i32 = 11_363;

/// What an armed drive stops and holds its load with: decelerations, slopes and powers.
const KEPT: [Setting; 7] = [
    Setting::AccelerationLimit,
    Setting::QuickStopDeceleration,
    Setting::CurrentSlope,
    Setting::TorqueModeSlope,
    Setting::PowerLimit,
    Setting::SupplyCurrentLimit,
    Setting::RegenerationCurrentLimit,
];

fn live() -> Vec<Setting> {
    Setting::live().collect()
}

/// Demanded current, A.
fn demand(wire: &Wire) -> f32 {
    match wire.outputs().bridge {
        BridgeDemand::Current(current) | BridgeDemand::Braking { current, .. } => current,
        _ => 0.0,
    }
}

/// The values of all live settings, as a client reads them.
fn values(wire: &mut Wire) -> Vec<i32> {
    live().iter().map(|setting| wire.get(*setting)).collect()
}

/// Lets the guard command for some time.
fn command(wire: &mut Wire, goal: Option<(i8, i32)>, milliseconds: u64) {
    for _ in 0..milliseconds {
        let state = wire
            .last()
            .map_or(State::SwitchOnDisabled, |_| wire.state());
        wire.command = Some(match goal {
            Some((mode, target)) => set_point(toward_operation(state), mode, target),
            None => set_point(0, 0, 0),
        });
        wire.tick(&[]);
    }
}

#[derive(Clone, Debug)]
enum Event {
    /// Writes the setting with this index: its value times this factor, or a value beside its
    /// bounds.
    Write(usize, f64),
    Beside(usize, bool),
    Move(i32),
    Torque(i32),
    Off,
    Load(f64),
    Fault(usize),
    Reset,
    /// Writes "save", which is kept in flash.
    Save,
    Restart,
}

fn events() -> impl Strategy<Value = Vec<Event>> {
    let index = 0..Setting::live().count();
    let event = prop_oneof![
        12 => (index.clone(), 0.3..1.7_f64).prop_map(|(index, factor)| Event::Write(index, factor)),
        1 => (index, any::<bool>()).prop_map(|(index, above)| Event::Beside(index, above)),
        4 => prop_oneof![Just(0), -6_000_000..6_000_000].prop_map(Event::Move),
        2 => (-900..900).prop_map(Event::Torque),
        2 => Just(Event::Off),
        1 => (-12.0..12.0_f64).prop_map(Event::Load),
        1 => (0..4_usize).prop_map(Event::Fault),
        1 => Just(Event::Reset),
        1 => Just(Event::Save),
        1 => Just(Event::Restart),
    ];
    vec(event, 1..40)
}

/// A drive, and what its settings must be.
struct Run {
    wire: Wire,
    expected: Vec<i32>,
    saved: Vec<i32>,
    goal: Option<(i8, i32)>,
}

impl Run {
    fn new() -> Self {
        let defaults: Vec<_> = live()
            .iter()
            .map(|setting| setting.bounds().default)
            .collect();
        Self {
            wire: Wire::axle(&[]),
            expected: defaults.clone(),
            saved: defaults,
            goal: None,
        }
    }

    fn value(&self, setting: Setting) -> i32 {
        let index = live().iter().position(|other| *other == setting);
        self.expected[index.expect("a live setting")]
    }

    /// Returns the abort code that this write must get.
    fn refusal(&self, setting: Setting, value: i32) -> Option<u32> {
        let row = setting.description();
        let armed = self
            .wire
            .last()
            .is_some_and(|outputs| outputs.bridge != BridgeDemand::Off);
        let limit = row.effect == Effect::Limit;
        let amperes = demand(&self.wire).abs().max(self.wire.rotor.current.abs());
        let speed = self
            .wire
            .last()
            .map_or(0.0, |outputs| outputs.velocity.abs());
        let below_present = match row.name {
            "current_limit" | "bench_current" => (value as f32) < amperes * 1e3,
            "velocity_limit" | "bench_speed" => (value as f32) < speed * 1e3,
            _ => false,
        };
        let largest = match row.name {
            "current_limit" => LARGEST_CURRENT,
            _ => row.maximum,
        };
        if value < row.minimum {
            Some(TOO_LOW)
        } else if value > largest {
            Some(TOO_HIGH)
        } else {
            let refused = armed
                && (row.effect == Effect::Disarmed
                    || limit && (value > self.value(setting) || below_present));
            refused.then_some(DEVICE_STATE)
        }
    }

    fn write(&mut self, index: usize, value: i32) -> Result<(), TestCaseError> {
        let setting = live()[index];
        let refusal = self.refusal(setting, value);
        prop_assert_eq!(
            self.wire.set(setting, value),
            refusal,
            "{:?} = {}",
            setting,
            value
        );
        if refusal.is_none() {
            self.expected[index] = value;
        }
        let read = values(&mut self.wire);
        prop_assert_eq!(&read, &self.expected, "{:?} = {}", setting, value);
        Ok(())
    }

    fn follow(&mut self, event: &Event) -> Result<(), TestCaseError> {
        match *event {
            Event::Write(index, factor) => {
                let value = (f64::from(self.expected[index]) * factor) as i32;
                // A higher one waits for the next start.
                let bears = match live()[index] {
                    Setting::VelocityLimit => LARGEST_VELOCITY,
                    _ => i32::MAX,
                };
                return self.write(index, value.min(bears));
            }
            Event::Beside(index, above) => {
                let row = live()[index].bounds();
                let value = if above {
                    row.maximum + 1
                } else {
                    row.minimum - 1
                };
                return self.write(index, value);
            }
            Event::Move(target) => self.goal = Some((mode::CYCLIC_VELOCITY, target)),
            Event::Torque(target) => self.goal = Some((mode::CYCLIC_TORQUE, target)),
            Event::Off => self.goal = None,
            Event::Load(torque) => self.wire.rotor.load = torque,
            Event::Fault(index) => self.wire.report(
                [
                    Fault::OverCurrent,
                    Fault::GuardLost,
                    Fault::Blocked,
                    Fault::OverTemperature,
                ][index],
            ),
            Event::Reset => {
                self.wire.command = Some(set_point(0x80, 0, 0));
                self.wire.run(20);
            }
            Event::Save => {
                let armed =
                    self.wire.last().is_some() && self.wire.outputs().bridge != BridgeDemand::Off;
                let refusal = self.wire.save();
                prop_assert_eq!(refusal, armed.then_some(DEVICE_STATE));
                if !armed {
                    self.saved.clone_from(&self.expected);
                }
            }
            Event::Restart => {
                let saved: Vec<_> = live().into_iter().zip(self.saved.iter().copied()).collect();
                self.wire = Wire::axle(&saved);
                self.expected.clone_from(&self.saved);
                self.goal = None;
            }
        }
        self.run(30)
    }

    fn run(&mut self, milliseconds: u64) -> Result<(), TestCaseError> {
        let limit = self.value(Setting::CurrentLimit) as f32 * 1e-3;
        for _ in 0..milliseconds {
            command(&mut self.wire, self.goal, 1);
            prop_assert!(demand(&self.wire).abs() <= limit * 1.000_01);
        }
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn no_sequence_raises_a_limit_of_an_armed_drive_or_loses_a_written_value(events in events()) {
        let mut run = Run::new();
        run.run(5)?;
        for event in &events {
            let (before, armed) = (run.expected.clone(), run.wire.outputs().bridge != BridgeDemand::Off);
            run.follow(event)?;
            if armed && !matches!(event, Event::Restart) {
                let limits = live().into_iter().zip(before.iter().zip(&run.expected));
                for (setting, (before, after)) in limits {
                    prop_assert!(setting.effect() == Effect::Gain || after <= before, "{setting:?}");
                    prop_assert!(after >= before || !KEPT.contains(&setting), "{setting:?}");
                }
            }
        }
        prop_assert_eq!(values(&mut run.wire), run.expected);
        prop_assert_eq!(run.wire.read((0x2020, 7))[0], 0, "no restart is needed");
    }

    /// The drive that gets the values while it is off, or while it stands armed, and the one that
    /// starts with them, get the same current in each tick of the same motion.
    #[test]
    fn a_drive_with_written_values_is_bit_identical_to_one_that_started_with_them(
        factors in vec(0.4..1.0_f64, Setting::live().count()),
        armed in any::<bool>(),
        screw in any::<bool>(),
        target in 2_000_000..6_000_000_i32,
        torque in any::<bool>(),
    ) {
        let new = |changes: &[(Setting, i32)]| if screw { Wire::screw(changes) } else { Wire::axle(changes) };
        let mut written = new(&[]);
        let changes: Vec<_> = live()
            .into_iter()
            .zip(&factors)
            .map(|(setting, factor)| (setting, (f64::from(written.get(setting)) * factor) as i32))
            .collect();
        let mut started = new(&changes);
        let (at_rest, moving) = if torque {
            ((mode::CYCLIC_TORQUE, 0), (mode::CYCLIC_TORQUE, target / 10_000))
        } else {
            ((mode::CYCLIC_VELOCITY, 0), (mode::CYCLIC_VELOCITY, target))
        };
        let goal = armed.then_some(at_rest);
        let (before, then): (Vec<_>, Vec<_>) = changes
            .into_iter()
            .partition(|(setting, _)| setting.effect() == Effect::Disarmed);
        for (goal, changes) in [(None, before), (goal, then)] {
            for wire in [&mut written, &mut started] {
                command(wire, goal, 60);
            }
            for (setting, value) in changes {
                prop_assert_eq!(written.set(setting, value), None, "{:?}", setting);
            }
        }
        let mut moved = 0.0_f32;
        for (load, goal) in [(0.0, at_rest), (0.0, moving), (0.2, moving), (0.0, at_rest)] {
            for wire in [&mut written, &mut started] {
                wire.rotor.load = load;
            }
            for tick in 0..100 {
                for wire in [&mut written, &mut started] {
                    command(wire, Some(goal), 1);
                }
                let [a, b] = [&written, &started].map(super::wire::Wire::outputs);
                prop_assert_eq!(a.bridge, b.bridge, "{} {:?}", tick, goal);
                prop_assert_eq!(a.faults, b.faults);
                moved = moved.max(a.velocity.abs());
            }
        }
        prop_assert!(moved > 0.1, "{moved}");
    }
}

/// Drives against a load, with this write after a second. Returns the demands of the 20 ticks after
/// it.
fn demands(write: Option<(Setting, i32)>) -> Vec<f32> {
    let mut wire = Wire::axle(&[(Setting::AccelerationFeedForward, 20_000)]);
    wire.rotor.load = -9.0;
    command(&mut wire, Some((mode::CYCLIC_VELOCITY, 2_000_000)), 1_000);
    command(&mut wire, Some((mode::CYCLIC_VELOCITY, 4_000_000)), 40);
    if let Some((setting, value)) = write {
        assert_eq!(wire.set(setting, value), None);
    }
    (0..20)
        .map(|_| {
            command(&mut wire, Some((mode::CYCLIC_VELOCITY, 4_000_000)), 1);
            demand(&wire)
        })
        .collect()
}

#[test]
fn the_current_of_a_moving_drive_does_not_jump_when_a_gain_changes() {
    let before = demands(None);
    assert!(before[0] > 3.0, "it is under load: {before:?}");
    for (setting, values) in [
        (Setting::PositionGain, [10_000, 40_000]),
        (Setting::VelocityGain, [1_500, 6_000]),
        (Setting::VelocityIntegralTime, [25_000, 200_000]),
        (Setting::AccelerationFeedForward, [0, 60_000]),
    ] {
        for value in values {
            let after = demands(Some((setting, value)));
            // Without the integral, the velocity gain alone changes the current by 0.5 A.
            let jump = (after[0] - before[0]).abs();
            assert!(
                jump < 0.05,
                "{setting:?} = {value}: {jump} A\n{before:?}\n{after:?}"
            );
        }
    }
}

#[test]
fn a_lower_limit_acts_on_a_moving_drive_at_once() {
    let mut wire = Wire::axle(&[]);
    command(&mut wire, Some((mode::CYCLIC_VELOCITY, 5_000_000)), 1_000);
    // Above the new speed, and higher.
    assert_eq!(wire.set(Setting::VelocityLimit, 4_000), Some(DEVICE_STATE));
    assert_eq!(wire.set(Setting::VelocityLimit, 6_001), Some(DEVICE_STATE));
    assert_eq!(wire.set(Setting::CurrentLimit, 10_001), Some(DEVICE_STATE));
    assert_eq!(wire.set(Setting::VelocityLimit, 5_100), None);
    command(&mut wire, Some((mode::CYCLIC_VELOCITY, 5_900_000)), 500);
    let velocity = wire.outputs().velocity;
    assert!((velocity - 5.1).abs() < 0.1, "{velocity}");
    assert_eq!(wire.set(Setting::CurrentLimit, 4_000), None);
    wire.rotor.load = -20.0;
    for _ in 0..30 {
        command(&mut wire, Some((mode::CYCLIC_VELOCITY, 5_900_000)), 1);
        assert!(demand(&wire).abs() <= 4.0);
    }
    assert!(demand(&wire) > 3.9, "{}", demand(&wire));
    assert_eq!(wire.set(Setting::CurrentLimit, 3_000), Some(DEVICE_STATE));
    assert_eq!(wire.get(Setting::CurrentLimit), 4_000);
}

/// The motor that is written next may allow it.
#[test]
fn a_velocity_limit_that_the_present_motor_does_not_allow_waits_for_the_next_start() {
    let mut wire = Wire::axle(&[]);
    wire.run(5);
    let written = LARGEST_VELOCITY + 1;
    assert_eq!(wire.set(Setting::VelocityLimit, written), None);
    assert_eq!(wire.get(Setting::VelocityLimit), written);
    assert_eq!(wire.read((0x2020, 7))[0], 1, "a restart is needed");
    command(&mut wire, Some((mode::CYCLIC_VELOCITY, 9_000_000)), 1_000);
    let velocity = wire.outputs().velocity;
    assert!((velocity - 6.0).abs() < 0.1, "the default: {velocity}");
    // The value that waits is no limit of the drive that moves.
    assert_eq!(wire.set(Setting::VelocityLimit, 8_000), Some(DEVICE_STATE));
    // It waits also when another setting takes effect.
    assert_eq!(wire.set(Setting::PositionGain, 4_000), None);
    command(&mut wire, Some((mode::CYCLIC_VELOCITY, 9_000_000)), 1_000);
    let velocity = wire.outputs().velocity;
    assert!((velocity - 6.0).abs() < 0.1, "the default: {velocity}");
}

/// A drive that moves must be able to stop, whatever a client writes.
#[test]
fn a_moving_drive_refuses_a_limit_that_would_keep_it_from_stopping() {
    let mut wire = Wire::axle(&[]);
    command(&mut wire, Some((mode::CYCLIC_VELOCITY, 5_000_000)), 1_000);
    for setting in live() {
        if KEPT.contains(&setting) {
            let lowest = setting.bounds().minimum;
            assert_eq!(wire.set(setting, lowest), Some(DEVICE_STATE), "{setting:?}");
        }
    }
    let state = wire.state();
    wire.command = Some(set_point(0x02, mode::CYCLIC_VELOCITY, 5_000_000));
    wire.run(1_000);
    assert_eq!(state, State::OperationEnabled);
    let velocity = wire.outputs().velocity;
    assert!(velocity.abs() < 0.01, "{velocity}");
}

#[test]
fn a_setting_that_is_not_live_needs_a_restart_and_says_so() {
    let mut wire = Wire::axle(&[]);
    wire.run(5);
    for setting in live() {
        assert_eq!(
            wire.set(setting, Settings::default().get(setting).max(1) - 1),
            None
        );
        assert_eq!(wire.read((0x2020, 7))[0], 0, "{setting:?}");
    }
    assert_eq!(wire.set(Setting::GearRatio, 50_000), None);
    assert_eq!(wire.read((0x2020, 7))[0], 1);
}
