//! A supply that cannot take power back: its capacitor is all that absorbs the energy of braking.

use super::rig::{GEAR, PER_RADIAN, Rig, Supply, Trouble, model, settings};
use std::fs;
use tautrack::faults::{ALL, Fault, Faults, Reaction};
use tautrack::motor::board_limits::largest_velocity;
use tautrack::node::axle::BridgeDemand;
use tautrack::sensors::Temperatures;
use tautrack::settings::Setting;

/// Runs a drive on a battery of 24 V with a diode, and a capacitor, F. The energy that the bridge
/// returns follows from the balance of the rotor: what it loses, minus friction and copper.
struct Balance {
    capacitor: f64,
    voltage: f64,
    kinetic: f64,
}

impl Balance {
    /// Runs a control period. Returns whether a current in d burns energy.
    fn tick(&mut self, rig: &mut Rig) -> bool {
        rig.supply_voltage = self.voltage as f32;
        let outputs = rig.tick();
        if let Some(fault) = outputs.faults.strongest() {
            panic!("{} at {} V", fault.description().name, self.voltage);
        }
        let parameters = model(true);
        let velocity = f64::from(rig.motor.shaft().velocity);
        let inertia = f64::from(parameters.rotor_inertia) * GEAR * GEAR;
        let kinetic = 0.5 * inertia * velocity * velocity;
        let friction = f64::from(parameters.friction_torque) * velocity.abs() * 1e-3;
        let [a, b] = rig.motor.readings().currents.map(|code| {
            (f64::from(code) - 32_768.0) / 32_768.0 * f64::from(super::rig::STAGE.full_scale)
        });
        let copper = 0.3 * (a * a + b * b + (a + b) * (a + b)) * 1e-3;
        let returned = self.kinetic - kinetic - friction - copper;
        self.kinetic = kinetic;
        let energy = 0.5 * self.capacitor * self.voltage * self.voltage + returned;
        self.voltage = (2.0 * energy / self.capacitor).sqrt().max(24.0);
        matches!(outputs.bridge, BridgeDemand::Braking { .. })
    }
}

/// Brakes from 5.5 rad/s to standstill. Returns the highest voltage, the milliseconds, and whether
/// a current in d burnt energy.
fn brake(changes: &[(Setting, i32)]) -> (f64, usize, bool) {
    let mut rig = Rig::new(true, changes);
    let mut balance = Balance {
        capacitor: 2e-3,
        voltage: 24.0,
        kinetic: 0.0,
    };
    rig.target = (5.5 * PER_RADIAN) as i32;
    for _ in 0..1_000 {
        balance.tick(&mut rig);
    }
    rig.target = 0;
    let (mut highest, mut burnt) = (0.0_f64, false);
    for milliseconds in 0..2_000 {
        burnt |= balance.tick(&mut rig);
        highest = highest.max(balance.voltage);
        if rig.motor.shaft().velocity.abs() < 0.02 {
            return (highest, milliseconds, burnt);
        }
    }
    panic!("still moving");
}

#[test]
fn a_three_phase_motor_brakes_to_standstill_below_the_over_voltage_of_a_supply_that_takes_nothing()
{
    let (highest, milliseconds, burnt) = brake(&[]);
    println!("at most {highest} V, {milliseconds} ms");
    assert!(burnt && highest < 31.7, "{highest}");
    // As fast as the acceleration limit of 20 rad/s^2 asks, and the lag of the loops.
    assert!(milliseconds < 400, "{milliseconds}");
}

#[test]
#[should_panic(expected = "over-voltage")]
fn without_the_limit_the_same_stop_ends_in_over_voltage() {
    brake(&[(Setting::RegenerationVoltage, 60_000)]);
}

/// Supply voltage that no fault may exceed, V.
const LARGEST: f64 = 36.0;
/// Battery of five cells, and the bound of the board's default settings, V.
const BATTERY: f64 = 21.0;
const BOUND: i32 = 25_000;
const CAPACITORS: [f64; 3] = [100e-6, 400e-6, 2e-3];
const INERTIAS: [f32; 3] = [1.0, 3.0, 10.0];

/// Lets the cause of a fault begin.
fn provoke(rig: &mut Rig, fault: Fault) {
    match fault {
        Fault::InvalidReading => rig.temperatures.bridge = Some(f32::NAN),
        Fault::OverTemperature => rig.temperatures.bridge = Some(120.0),
        Fault::ControlOverrun => rig.trouble = Trouble::MissedInterrupts,
        // The shaft cannot turn from the start.
        Fault::Blocked => {}
        // Something else charges the supply.
        Fault::OverVoltage => rig.supply.as_mut().expect("a supply").battery = 25.2,
        // The fuse has blown.
        Fault::UnderVoltage => rig.supply.as_mut().expect("a supply").battery = 0.0,
        _ => panic!("no reaction brakes"),
    }
}

/// Highest supply voltage from this fault on, and whether the fault came. It begins while the drive
/// runs at this speed, or has braked for so many milliseconds.
fn peak(
    three_phase: bool,
    fault: Fault,
    capacitor: f64,
    inertia: f32,
    speed: f64,
    braking: usize,
) -> (f64, bool) {
    let changes = [
        (Setting::OverVoltage, BOUND),
        (Setting::RegenerationVoltage, 23_000),
        (Setting::BridgeTemperature, 800),
        (Setting::AccelerationLimit, 100_000),
    ];
    let mut model = model(three_phase);
    model.rotor_inertia *= inertia;
    let stuck = fault == Fault::Blocked;
    if stuck {
        model.friction_torque = 100.0;
    }
    let mut rig = Rig::with_model(model, &settings(three_phase, &changes));
    rig.supply = Some(Supply::new(BATTERY, capacitor, f64::from(BOUND) / 1e3));
    rig.supply_voltage = BATTERY as f32;
    rig.temperatures = Temperatures {
        bridge: Some(25.0),
        motor: None,
    };
    rig.target = (speed * PER_RADIAN) as i32;
    while !stuck && rig.motor.shaft().velocity.abs() < 0.98 * speed.abs() as f32 {
        rig.tick();
    }
    if braking > 0 {
        rig.target = 0;
    }
    for _ in 0..braking {
        rig.tick();
    }
    provoke(&mut rig, fault);
    if stuck {
        rig.target = PER_RADIAN as i32;
    }
    let (mut highest, mut came) = (0.0_f64, false);
    for _ in 0..400 {
        let outputs = rig.tick();
        came |= outputs.faults.contains(fault);
        highest = highest.max(rig.supply.expect("a supply").voltage);
    }
    (highest, came)
}

/// The faults with this reaction.
fn faults_with(reaction: Reaction) -> impl Iterator<Item = Fault> {
    let reacts = move |fault: &Fault| fault.description().reaction == reaction;
    ALL.iter().copied().filter(reacts)
}

/// Highest supply voltage of a fault: of both motors, at full and half speed, in both directions.
fn highest(fault: Fault, capacitor: f64, inertia: f32) -> f64 {
    let (mut highest, mut came) = (0.0_f64, false);
    for three_phase in [false, true] {
        for speed in [6.0, -3.0] {
            for braking in [0, 1, 2, 4, 8] {
                let (peak, fault) = peak(three_phase, fault, capacitor, inertia, speed, braking);
                highest = highest.max(peak);
                came |= fault;
            }
        }
    }
    assert!(came, "{fault:?} does not come");
    highest
}

/// Highest supply voltage from the moment in which the bridge opens at the highest speeds that a
/// board allows: because of this fault at 97 % of `velocity_limit`, where a three-phase motor
/// drives with a weakened field, or has braked for so many milliseconds; "overspeed" comes at
/// 120 %. A load of 40 N m helps the motor until then.
fn fastest_peak(
    three_phase: bool,
    fault: Fault,
    capacitor: f64,
    inertia: f32,
    braking: usize,
) -> f64 {
    let mut changes = vec![
        (Setting::FieldWeakeningCurrent, 9_000),
        (Setting::OverVoltage, BOUND),
        (Setting::RegenerationVoltage, 23_000),
        (Setting::AccelerationLimit, 100_000),
    ];
    let limit = largest_velocity(&settings(three_phase, &changes), LARGEST as f32);
    changes.push((Setting::VelocityLimit, (limit * 1e3) as i32));
    let mut model = model(three_phase);
    model.rotor_inertia *= inertia;
    let mut rig = Rig::with_model(model, &settings(three_phase, &changes));
    rig.supply = Some(Supply::new(BATTERY, capacitor, f64::from(BOUND) / 1e3));
    rig.supply_voltage = BATTERY as f32;
    rig.target = (f64::from(limit) * PER_RADIAN) as i32;
    let overspeed = fault == Fault::Overspeed;
    let fastest = if overspeed { 1.2 } else { 0.97 } * limit;
    let (mut highest, mut ticks) = (0.0_f64, 0);
    while rig.motor.shaft().velocity < fastest {
        if rig.motor.shaft().velocity > 0.7 * limit {
            rig.load = -40.0;
        }
        if !rig.tick().faults.is_empty() {
            // The supply is too high: a brushed motor above it charges it without control.
            highest = highest.max(rig.supply.expect("a supply").voltage);
        }
        ticks += 1;
        assert!(ticks < 5_000, "{} rad/s", rig.motor.shaft().velocity);
    }
    rig.load = 0.0;
    if braking > 0 {
        rig.target = 0;
    }
    for _ in 0..braking {
        rig.tick();
    }
    rig.axle.report(Faults::of(fault));
    for _ in 0..400 {
        let outputs = rig.tick();
        let ended = matches!(outputs.bridge, BridgeDemand::Off | BridgeDemand::Brake);
        assert!(ended, "{fault:?}");
        highest = highest.max(rig.supply.expect("a supply").voltage);
    }
    highest
}

/// Highest supply voltage of all faults that open or short the bridge at such speeds, of both
/// motors.
fn highest_of_all(capacitor: f64, inertia: f32) -> f64 {
    let mut highest = 0.0_f64;
    for three_phase in [false, true] {
        for fault in faults_with(Reaction::Off).chain(faults_with(Reaction::Brake)) {
            let times: &[usize] = match fault {
                Fault::OverCurrent => &[0, 1, 2, 4, 8],
                _ => &[0],
            };
            for braking in times {
                let peak = fastest_peak(three_phase, fault, capacitor, inertia, *braking);
                highest = highest.max(peak);
            }
        }
    }
    highest
}

/// Rows of the table of the page docs/motor.md behind this text, without its head.
fn table_after(text: &str) -> Vec<Vec<String>> {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/motor.md");
    let page = fs::read_to_string(page).expect("the page");
    let (_, behind) = page.split_once(text).expect("the table");
    let rows = behind.lines().skip_while(|line| !line.starts_with('|'));
    let rows = rows.take_while(|line| line.starts_with('|')).skip(2);
    let cells = |row: &str| {
        row.trim_matches('|')
            .split('|')
            .map(|cell| cell.trim().to_owned())
            .collect()
    };
    rows.map(cells).collect()
}

/// A row of the table. No voltage may be above [`LARGEST`].
fn row(name: String, peak: impl Fn(f64, f32) -> f64) -> Vec<String> {
    let mut row = vec![name];
    for capacitor in CAPACITORS {
        let volts = INERTIAS.map(|inertia| peak(capacitor, inertia));
        assert!(
            volts.iter().all(|volts| *volts < LARGEST),
            "{} {capacitor}: {volts:?}",
            row[0]
        );
        row.push(volts.map(|volts| format!("{volts:.0}")).join(", "));
    }
    row
}

#[test]
fn no_fault_charges_the_supply_above_36_v_as_the_page_says() {
    let mut rows: Vec<_> = faults_with(Reaction::Brake)
        .map(|fault| {
            let code = format!("`{:#06X}`", fault.code()).replace("0X", "0x");
            row(code, |capacitor, inertia| {
                highest(fault, capacitor, inertia)
            })
        })
        .collect();
    rows.push(row("any, highest speed".to_owned(), highest_of_all));
    for row in &rows {
        println!("| {} |", row.join(" | "));
    }
    assert_eq!(table_after("Peak of the supply voltage"), rows);
}
