//! Watches the readings of one axle for faults. Each watch has a dwell (the time for which its
//! condition must last), so that no single sample raises a fault.

use crate::faults::{Fault, Faults};
use crate::math::Turns;
use crate::motor::back_emf::Findings;
use crate::motor::current::Electrical;
use crate::motor::limits::OVERSPEED;
use crate::sensors::Temperatures;
use crate::settings::{Setting, Settings};

/// What the current loop does.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Power {
    Off,
    On,
    /// It holds the axle, and needs more than the hold current.
    Strained,
}

/// Readings of one tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Readings {
    /// Measured current, A; NaN if no sample was taken.
    pub current: f32,
    /// Commanded current, A. A motor that runs away behind a frozen encoder draws less current than
    /// commanded.
    pub demand: f32,
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// Measured velocity, rad/s.
    pub velocity: f32,
    /// Velocity of the set-point, rad/s.
    pub commanded_velocity: f32,
    /// Distance between set-point and position, 2^-32 turn; 0 if the mode has no position.
    pub following_error: Turns,
    pub power: Power,
    /// What the voltage of the bridge shows.
    pub motor: Findings,
    /// The rotor could not be aligned.
    pub misaligned: bool,
    /// The encoder made impossible steps.
    pub noisy: bool,
    /// Temperatures of bridge and motor.
    pub temperatures: Temperatures,
    /// Further measurements of the bridge.
    pub electrical: Electrical,
}

impl Readings {
    /// Returns whether more mechanical power goes into the motor than heats it, so that the rest
    /// flows into the supply.
    fn gives_energy_back(&self) -> bool {
        let Some([direct, torque]) = self.electrical.voltage else {
            return false;
        };
        direct * self.electrical.direct + torque * self.current < 0.0
    }
}

/// Thresholds of a blocked motor, which does not turn although nearly the full current is
/// commanded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stall {
    /// Commanded current above which a motor must turn, A.
    pub pushing: f32,
    /// Speed below which a motor counts as standing, rad/s.
    pub standing: f32,
}

/// Bounds of the watches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    over_current: f32,
    /// Commanded current above which the motor counts as driven in one direction, A: half of the
    /// current limit.
    driving: f32,
    overspeed: f32,
    /// Difference of two velocities that no control error explains, rad/s.
    deviation: f32,
    following: u64,
    under_voltage: f32,
    over_voltage: f32,
    /// Temperatures of bridge and motor, degree Celsius; 0 without a sensor.
    temperatures: [f32; 2],
}

/// The watched faults, and for how many ticks the condition of each must last.
const WATCHES: [(Fault, u8); 16] = [
    (Fault::OverCurrent, 5),
    (Fault::Overspeed, 3),
    (Fault::VelocityDeviation, 25),
    (Fault::OpenPhase, 8),
    (Fault::EncoderMismatch, 8),
    (Fault::RotorAngle, 1),
    (Fault::EncoderNoise, 1),
    (Fault::Misaligned, 1),
    (Fault::InvalidReading, 3),
    (Fault::OverVoltage, 5),
    (Fault::UnderVoltage, 5),
    (Fault::OverTemperature, 20),
    (Fault::ControlOverrun, 3),
    (Fault::Blocked, 40),
    (Fault::FollowingError, 100),
    (Fault::HoldOverload, 32),
];

/// Counters of the watches.
#[derive(Clone, Debug)]
pub(super) struct Watches {
    /// Ticks for which the condition of each watch has lasted.
    lasted: [u8; WATCHES.len()],
    /// Lowest speed since the axle began to move away from its set-point against its current,
    /// rad/s.
    slowest: f32,
}

impl Default for Watches {
    fn default() -> Self {
        Self {
            lasted: [0; WATCHES.len()],
            slowest: f32::INFINITY,
        }
    }
}

impl Bounds {
    /// Reads the bounds from the axle's settings.
    pub fn new(settings: &Settings) -> Self {
        let current = settings.si(Setting::CurrentLimit);
        let velocity = settings.si(Setting::VelocityLimit);
        let following = Turns::from_radians(settings.si(Setting::FollowingLimit));
        Self {
            over_current: 1.25 * current,
            driving: 0.5 * current,
            overspeed: OVERSPEED * velocity,
            deviation: 0.2 * velocity,
            following: following.distance(),
            under_voltage: settings.si(Setting::UnderVoltage),
            over_voltage: settings.si(Setting::OverVoltage),
            temperatures: [Setting::BridgeTemperature, Setting::MotorTemperature]
                .map(|setting| settings.si(setting)),
        }
    }

    /// Returns whether a temperature is above its bound, and whether a sensor that must be there
    /// gives no reading.
    fn temperatures(&self, now: Temperatures) -> (bool, bool) {
        let (mut above, mut missing) = (false, false);
        for (bound, reading) in self.temperatures.into_iter().zip([now.bridge, now.motor]) {
            if bound > 0.0 {
                let reading = reading.unwrap_or(f32::NAN);
                above |= reading > bound;
                missing |= !(reading.abs() < f32::INFINITY);
            }
        }
        (above, missing)
    }
}

impl Watches {
    /// Returns the faults whose condition has lasted for its dwell and still lasts. The comparisons
    /// are written so that NaN counts as bad.
    pub fn check(&mut self, now: &Readings, bounds: &Bounds, stall: Stall) -> Faults {
        let (current, speed) = (now.current.abs(), now.velocity.abs());
        let powered = now.power != Power::Off;
        // No reading is so large that the sum of two overflows.
        let finite = current + now.supply_voltage.abs() < f32::INFINITY;
        let pushes = now.power == Power::On && !(now.demand.abs() <= stall.pushing);
        let blocked = pushes && speed < stall.standing;
        let deviating = self.deviates(now, bounds) && powered;
        let (hot, missing) = bounds.temperatures(now.temperatures);
        // In the order of `WATCHES`.
        let bad = [
            !(current <= bounds.over_current),
            powered && !(speed <= bounds.overspeed),
            deviating,
            now.motor.open_phase && powered,
            now.motor.disagrees && powered,
            now.motor.slipped && powered,
            now.noisy && powered,
            now.misaligned,
            !finite || missing || now.electrical.wrong_sum,
            !(now.supply_voltage <= bounds.over_voltage),
            !(now.supply_voltage >= bounds.under_voltage),
            hot,
            now.electrical.overrun,
            blocked,
            now.following_error.distance() > bounds.following,
            now.power == Power::Strained,
        ];
        let mut faults = Faults::NONE;
        for ((lasted, bad), (fault, dwell)) in self.lasted.iter_mut().zip(bad).zip(WATCHES) {
            *lasted = if bad { lasted.saturating_add(1) } else { 0 };
            faults.insert_if(fault, *lasted >= dwell);
        }
        faults.insert_if(Fault::OverCurrent, now.electrical.over_current);
        faults.insert_if(Fault::OverVoltage, now.electrical.over_voltage);
        faults
    }

    /// Returns whether the axle has gathered speed away from its set-point, against a current that
    /// drives it back.
    ///
    /// In normal use this does not happen. A load that the motor brakes loses speed. An axle that
    /// lags behind its set-point moves in the direction of its current. An axle that follows a ramp
    /// stays near its set-point. Only a motor whose current acts in the wrong direction does this:
    /// encoder channels or motor leads are swapped. A blow to the robot swings the rotor within its
    /// gear for some 10 ms at a time; the dwell is longer. A stronger blow throws the axle, but
    /// then the motor brakes it and gives energy back. A motor that drives itself never does,
    /// whatever the angle of its rotor is.
    fn deviates(&mut self, now: &Readings, bounds: &Bounds) -> bool {
        let speed = now.velocity.abs();
        let apart = now.velocity - now.commanded_velocity;
        let against = now.velocity * now.demand < 0.0
            && apart * now.demand < 0.0
            && now.demand.abs() > bounds.driving
            && apart.abs() > bounds.deviation
            && !now.gives_energy_back();
        if !against || speed < self.slowest {
            self.slowest = speed;
        }
        against && speed > self.slowest + bounds.deviation
    }
}

#[cfg(test)]
mod tests;
