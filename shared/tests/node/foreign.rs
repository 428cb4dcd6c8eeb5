//! Frames of nodes that send in the name of another one: of the guard, of the chassis joint, or of
//! the drive itself.

use super::wire::{ID, JOINT, SYNC_MS, Wire, motion, set_point};
use tautrack::bus::cia402::{State, mode};
use tautrack::can::Frame;
use tautrack::faults::Fault;
use tautrack::settings::Setting;

/// Travel of an axle at its velocity limit of 6 rad/s in 20 ms, rad.
const TRAVEL: f64 = 6.0 * 20e-3;
/// Bit of the statusword in homing mode.
const HOMING_ATTAINED: u16 = 1 << 12;
/// Millimetres per rad of the screw's shaft.
const LEAD: f64 = 5.0 / std::f64::consts::TAU;

/// The guard commands a quick stop while another node commands motion. It sends `burst` frames in
/// each millisecond that `sends` selects.
fn second_master(wire: &mut Wire, frame: Frame, burst: usize, sends: impl Fn(u64) -> bool) {
    let start = wire.rotor.angle;
    for millisecond in 0..3_000 {
        let now = wire.milliseconds() + 1;
        let foreign = vec![frame; if sends(now) { burst } else { 0 }];
        wire.tick(&foreign);
        let (moved, state) = (wire.rotor.angle - start, wire.state());
        assert_ne!(
            state,
            State::OperationEnabled,
            "{millisecond} ms, {frame:?}"
        );
        assert!(
            moved.abs() < TRAVEL,
            "{moved} rad after {millisecond} ms, {frame:?}"
        );
    }
}

#[test]
fn a_second_master_moves_no_drive_that_the_guard_holds_at_any_rate_and_phase() {
    for mode in [
        mode::CYCLIC_VELOCITY,
        mode::CYCLIC_TORQUE,
        mode::CYCLIC_POSITION,
    ] {
        let frame = set_point(0x0f, mode, 6_000_000);
        for every in [1, 2, 4, 7, 20] {
            for phase in 0..every.min(4) {
                let mut wire = Wire::axle(&[]);
                wire.operate(mode::CYCLIC_VELOCITY, 0);
                wire.command = Some(set_point(0x02, 0, 0));
                wire.run(100);
                second_master(&mut wire, frame, 1, |now| now % every == phase);
                assert_eq!(wire.state(), State::QuickStopActive, "{every} {phase}");
                assert!(wire.has(Fault::SecondMaster), "{every} {phase}");
            }
        }
    }
}

#[test]
fn a_drive_names_a_second_master_within_20_ms() {
    for every in [1, 2, 4, 7] {
        for phase in 0..every.min(4) {
            let mut wire = Wire::axle(&[]);
            wire.operate(mode::CYCLIC_VELOCITY, 1_000_000);
            let frame = set_point(0x0f, mode::CYCLIC_VELOCITY, -6_000_000);
            let start = wire.rotor.angle;
            let found = (0..20).any(|_| {
                let sends = (wire.milliseconds() + 1) % every == phase;
                wire.tick(if sends {
                    std::slice::from_ref(&frame)
                } else {
                    &[]
                });
                wire.has(Fault::SecondMaster)
            });
            assert!(found, "{every} {phase}");
            assert_eq!(wire.state(), State::QuickStopActive);
            wire.run(500);
            let moved = wire.rotor.angle - start;
            assert!(
                (moved - 1.0 * 0.02).abs() < TRAVEL,
                "{every} {phase}: {moved}"
            );
        }
    }
}

/// Whole sequences of commands that lead up from "switch on disabled", between two of the guard's.
#[test]
fn a_second_master_leads_no_drive_up_that_the_guard_holds() {
    for wait in [40, 100, 333] {
        let mut wire = Wire::axle(&[]);
        wire.command = Some(set_point(0x02, 0, 0));
        wire.run(100);
        for step in 0..3_000 {
            let up = [0x06, 0x07, 0x0f].map(|word| set_point(word, 9, 6_000_000));
            let sends = step % wait < 3;
            let foreign = if sends {
                &up[step % wait..=step % wait]
            } else {
                &[]
            };
            wire.tick(foreign);
            assert_ne!(wire.state(), State::OperationEnabled, "{wait}: {step} ms");
        }
        assert!(wire.rotor.angle.abs() < TRAVEL, "{} rad", wire.rotor.angle);
    }
}

/// The drive brakes by shorting its winding, and after a reset it would let the load go.
#[test]
fn no_frame_of_another_node_resets_a_fault() {
    for word in [0x80, 0x82, 0x8f] {
        for every in [1, 2, 3, 4, 5, 37, 101] {
            for phase in 0..every.min(4) {
                let mut wire = Wire::axle(&[]);
                wire.operate(mode::CYCLIC_VELOCITY, 1_000_000);
                wire.report(Fault::Blocked);
                wire.command = Some(set_point(0x02, 0, 0));
                let frame = set_point(word, 0, 0);
                for step in 0..500 {
                    let sends = (wire.milliseconds() + 1) % every == phase;
                    wire.tick(&vec![frame; usize::from(sends)]);
                    assert!(
                        wire.has(Fault::Blocked),
                        "{word:#x} {every} {phase}: {step}"
                    );
                }
                wire.run(20);
                wire.command = Some(set_point(0x82, 0, 0));
                wire.run(12);
                assert!(!wire.has(Fault::Blocked), "{word:#x} {every} {phase}");
            }
        }
    }
}

#[test]
fn no_frame_of_another_node_switches_off_a_drive_under_power() {
    let holding = set_point(0x02, 0, 0);
    let operating = set_point(0x0f, mode::CYCLIC_VELOCITY, 1_000_000);
    for command in [holding, operating] {
        for word in [0x00, 0x06, 0x07, 0x80, 0x04] {
            for every in [1, 2, 3, 4, 5, 37, 101] {
                let mut wire = Wire::axle(&[]);
                wire.operate(mode::CYCLIC_VELOCITY, 1_000_000);
                wire.command = Some(command);
                wire.run(100);
                let frame = set_point(word, 0, 0);
                for step in 0..1_000 {
                    let sends = (wire.milliseconds() + 1) % every == 1 % every;
                    wire.tick(if sends {
                        std::slice::from_ref(&frame)
                    } else {
                        &[]
                    });
                    // In the same millisecond as the guard's, the last frame counts.
                    let hidden = every == 1 || every == 4 && 1 % every == 0;
                    assert!(wire.powered() || hidden, "{word:#x} {every}: {step} ms");
                }
            }
        }
    }
}

#[test]
fn the_guard_switches_a_drive_off_within_30_ms_and_stops_it_at_once() {
    for word in [0x00, 0x06, 0x07] {
        let mut wire = Wire::axle(&[]);
        wire.operate(mode::CYCLIC_VELOCITY, 1_000_000);
        wire.command = Some(set_point(word, 0, 0));
        wire.run(30);
        assert!(!wire.powered(), "{word:#x}");
    }
    let mut wire = Wire::axle(&[]);
    wire.operate(mode::CYCLIC_VELOCITY, 1_000_000);
    wire.command = Some(set_point(0x02, 0, 0));
    wire.run(SYNC_MS);
    assert_eq!(wire.state(), State::QuickStopActive);
    wire.command = Some(set_point(0x0f, mode::CYCLIC_VELOCITY, 1_000_000));
    wire.run(30);
    assert_eq!(wire.state(), State::OperationEnabled);
}

#[test]
fn a_drive_that_receives_an_identifier_of_its_own_reports_it_and_stops() {
    for code in [0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x700] {
        let mut wire = Wire::axle(&[]);
        wire.operate(mode::CYCLIC_VELOCITY, 3_000_000);
        wire.run(500);
        let frame = Frame::new(code + u16::from(ID), &[5; 8]).unwrap();
        let outputs = wire.tick(&[frame]);
        assert_eq!(outputs.emergency, Some(0x8150), "{code:#x}");
        wire.run(400);
        assert_eq!(wire.state(), State::QuickStopActive);
        assert!(
            wire.rotor.velocity.abs() < 0.01,
            "{} rad/s",
            wire.rotor.velocity
        );
        // An identifier of somebody else.
        let mut wire = Wire::axle(&[]);
        wire.operate(mode::CYCLIC_VELOCITY, 3_000_000);
        let frame = Frame::new(code + u16::from(JOINT), &[5; 8]).unwrap();
        for _ in 0..100 {
            wire.tick(&[frame]);
        }
        assert!(wire.outputs().faults.is_empty(), "{code:#x}");
    }
}

/// A screw that keeps the belt taut at this angle of the joint.
fn taut(angle: f64) -> Wire {
    let mut wire = Wire::screw(&[]);
    wire.joint = Some((angle, 0.0));
    wire.operate(mode::TAUT, 0);
    wire.run(4_500);
    assert!(wire.outputs().faults.is_empty(), "{:?}", wire.outputs());
    assert!(wire.rotor.velocity.abs() < 0.1 && wire.rotor.angle > 200.0);
    wire
}

/// Runs a second. `foreign` returns the frames of a millisecond. The screw must stop within a
/// millimetre, and name the fault within 20 ms of the first of them.
fn forge(wire: &mut Wire, case: &str, foreign: impl Fn(u64) -> Vec<Frame>) {
    let (start, mut first, mut found) = (wire.rotor.angle, None, None);
    for step in 0..1_000 {
        let frames = foreign(step);
        if !frames.is_empty() {
            first = first.or(Some(step));
        }
        wire.tick(&frames);
        let moved = (wire.rotor.angle - start).abs() * LEAD;
        assert!(moved < 1.0, "{case}: {moved} mm after {step} ms");
        if wire.has(Fault::DuplicateId) {
            found = found.or(Some(step));
        }
    }
    let (first, found) = (first.expect("a frame"), found.expect(case));
    assert!(found - first < 20, "{case}: {first} to {found} ms");
}

#[test]
fn a_forged_motion_of_the_joint_moves_the_screw_by_less_than_a_millimetre() {
    for true_angle in [0.0, 0.7] {
        for forged in [0.3, 0.5, 1.0, -1.2, 3.0, 0.05] {
            for rate in [0.0, 2.0, -2_000.0] {
                for (every, phase) in [(1, 0), (4, 0), (4, 1), (4, 3), (3, 0)] {
                    let mut wire = taut(true_angle);
                    let frame = motion(true_angle + forged, rate);
                    let case = format!("{true_angle} {forged} {rate} {every} {phase}");
                    forge(&mut wire, &case, |step| {
                        vec![frame; usize::from(step % every == phase)]
                    });
                }
            }
        }
    }
}

#[test]
fn a_step_of_the_joint_that_velocity_and_age_do_not_explain_is_refused() {
    for step in [1.0, 0.3, -0.3] {
        // Its motion pauses for 20 ms, and goes on from another zero.
        for pause in [4, 12, 20] {
            let mut wire = taut(0.6);
            wire.joint = None;
            wire.run(pause);
            let frame = motion(0.6 + step, 0.0);
            forge(&mut wire, &format!("{step} after {pause}"), |now| {
                vec![frame; usize::from(now % 4 == 0)]
            });
        }
    }
}

#[test]
fn no_motion_that_a_joint_can_make_is_refused() {
    for (speed, acceleration) in [(2.5_f64, 8.0), (1.0, 40.0), (0.2, 200.0)] {
        let mut wire = taut(0.3);
        let (mut angle, mut rate) = (0.3, 0.0_f64);
        for step in 0..4_000 {
            let target = if step / 500 % 2 == 0 { speed } else { -speed };
            rate += (target - rate).clamp(-acceleration * 1e-3, acceleration * 1e-3);
            angle += rate * 1e-3;
            // Every tenth frame is lost.
            wire.joint = (step / 4 % 10 != 0).then_some((angle, rate));
            wire.tick(&[]);
            let refused = wire.has(Fault::DuplicateId);
            assert!(!refused, "{speed} rad/s, {acceleration} rad/s^2: {step} ms");
        }
    }
}

/// The joint moves while the screw holds. When it is enabled again, the screw takes up the
/// difference with the engage speed.
#[test]
fn a_screw_that_has_held_does_not_jump_to_where_the_joint_is_now() {
    let mut wire = taut(0.6);
    wire.command = Some(set_point(0x02, 0, 0));
    wire.run(100);
    for step in 0..200 {
        wire.joint = Some((0.6 + 1e-3 * f64::from(step), 0.0));
        wire.run(4);
    }
    wire.command = Some(set_point(0x0f, mode::TAUT, 0));
    let (mut fastest, start) = (0.0_f64, wire.rotor.angle);
    for _ in 0..600 {
        wire.tick(&[]);
        fastest = fastest.max(wire.rotor.velocity.abs());
    }
    assert_eq!(wire.state(), State::OperationEnabled);
    assert!((wire.rotor.angle - start).abs() * LEAD > 4.0);
    // 100 mm/s, with an overshoot of the loop.
    assert!(fastest * LEAD < 120.0, "{} mm/s", fastest * LEAD);
}

/// Option codes, homing method and position limits.
const PARAMETERS: [(u16, u8); 5] = [
    (0x605a, 0),
    (0x605e, 0),
    (0x6098, 0),
    (0x607d, 1),
    (0x607d, 2),
];

fn parameters(wire: &mut Wire) -> [[u8; 4]; 5] {
    PARAMETERS.map(|object| wire.read(object))
}

/// A client switches the bridge off where the drive would hold, homes where the drive stands, and
/// limits its travel.
fn write_parameters(wire: &mut Wire) {
    let [quick_stop, fault_reaction, homing_method, lower, upper] = PARAMETERS;
    wire.write(quick_stop, 0_i16.to_le_bytes());
    wire.write(fault_reaction, 0_i16.to_le_bytes());
    wire.write(homing_method, [37]);
    wire.write(lower, (-5_i32).to_le_bytes());
    wire.write(upper, 5_i32.to_le_bytes());
}

#[test]
fn what_a_client_has_written_before_the_guard_does_not_count_for_the_guard() {
    let changes = [(Setting::HomingDirection, 1)];
    let mut wire = Wire::axle(&changes);
    wire.guard = false;
    wire.write((0x2001, 0), [1]);
    wire.run(20);
    let saved = parameters(&mut wire);
    write_parameters(&mut wire);
    wire.run(20);
    let written = parameters(&mut wire);
    assert!((0..5).all(|index| written[index] != saved[index]));
    wire.guard = true;
    wire.run(100);
    assert_eq!(parameters(&mut wire), saved);
    wire.operate(mode::CYCLIC_VELOCITY, 1_000_000);
    wire.command = Some(set_point(0x02, 0, 0));
    wire.run(500);
    assert!(wire.powered());
    // The loss of the guard, too.
    let mut wire = Wire::axle(&changes);
    write_parameters(&mut wire);
    wire.operate(mode::CYCLIC_VELOCITY, 1_000_000);
    wire.guard = false;
    wire.run(500);
    assert!(wire.has(Fault::GuardLost) && wire.powered());
    // Homing looks for the switch.
    let mut wire = Wire::axle(&changes);
    write_parameters(&mut wire);
    wire.operate(mode::HOMING, 0);
    wire.command = Some(set_point(0x1f, mode::HOMING, 0));
    wire.run(500);
    let attained = wire.outputs().status.statusword & HOMING_ATTAINED != 0;
    assert!(!attained && wire.rotor.angle > 0.05);
}

#[test]
fn a_drive_holds_with_the_limits_of_operation_whatever_mode_another_node_names() {
    let mut wire = Wire::axle(&[(Setting::HomingCurrent, 1_000)]);
    wire.operate(mode::CYCLIC_VELOCITY, 0);
    let homing = set_point(0x02, mode::HOMING, 0);
    wire.command = Some(set_point(0x02, 0, 0));
    for _ in 0..100 {
        wire.tick(&[homing]);
    }
    let start = wire.rotor.angle;
    // More than the hold current bears, and more than homing's.
    wire.rotor.load = 16.0;
    for _ in 0..500 {
        wire.tick(&[homing]);
        let moved = (wire.rotor.angle - start).abs();
        assert!(moved < TRAVEL, "{moved} rad");
    }
}

#[test]
fn no_reset_of_another_node_weakens_a_hold_that_is_overloaded() {
    let mut wire = Wire::axle(&[]);
    wire.operate(mode::CYCLIC_VELOCITY, 0);
    wire.command = Some(set_point(0x02, 0, 0));
    wire.run(100);
    // The hold current bears 14.4 N m, the motor 24 N m.
    wire.rotor.load = 20.0;
    wire.run(500);
    assert!(wire.has(Fault::HoldOverload));
    let start = wire.rotor.angle;
    for step in 0..2_000 {
        let reset = set_point(0x82, 0, 0);
        wire.tick(&[reset][..usize::from(step % 9 == 0)]);
    }
    let moved = (wire.rotor.angle - start).abs();
    assert!(moved < TRAVEL, "{moved} rad");
}
