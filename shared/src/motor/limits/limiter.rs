//! The current limiter of the control task. docs/nodes.md lists what acts after it.

use super::ActiveLimit;
use super::heat::Heat;
use super::supply::{Supply, positive};
use super::voltage::{Readings, Voltage};
use crate::constants::CONTROL_PERIOD;
use crate::math::{limit, root_of_sum};
use crate::sensors::Temperatures;
use crate::settings::{Setting, Settings};

/// Speed at which the fault "overspeed" begins, in velocity limits.
pub const OVERSPEED: f32 = 1.2;

/// Readings of one control period.
#[derive(Clone, Copy, Debug)]
pub struct Conditions {
    /// Measured motor current, A.
    pub current: f32,
    /// Supply voltage, V.
    pub supply_voltage: f32,
    /// Amplitude of the bridge's voltage, V; 0 if it is not known.
    pub voltage: f32,
    /// Velocity of the output shaft, rad/s.
    pub velocity: f32,
    /// Temperatures of bridge and motor.
    pub temperatures: Temperatures,
}

/// Demand that all limits allow.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Limited {
    /// Current that makes the torque, A. It is never NaN.
    pub current: f32,
    /// Current in the axis d of a three-phase motor, A. It turns braking power into heat, weakens
    /// the field, or probes the rotor's angle ([`Limiter::add_direct`]).
    pub direct: f32,
    /// The limit that acts now.
    pub cause: ActiveLimit,
}

/// Largest current in one direction, A, and the limit that sets it.
#[derive(Clone, Copy, Debug)]
struct Side {
    bound: f32,
    cause: ActiveLimit,
}

impl Side {
    /// Lowers the bound to `bound`; to 0 if that is negative or NaN.
    #[inline]
    fn reduce(&mut self, bound: f32, cause: ActiveLimit) {
        if !(bound >= self.bound) {
            self.bound = positive(bound);
            self.cause = cause;
        }
    }
}

/// A temperature above which the current is reduced.
#[derive(Clone, Copy, Debug)]
struct Derating {
    /// Temperature at which no current is left, degree Celsius; 0 without a sensor.
    end: f32,
    /// A/K
    slope: f32,
}

impl Derating {
    fn allowed(self, temperature: Option<f32>) -> f32 {
        if self.end == 0.0 {
            return f32::INFINITY;
        }
        (self.end - temperature.unwrap_or(f32::NAN)) * self.slope
    }
}

/// Limits the current by everything that motor, bridge and supply can carry, and keeps the thermal
/// models.
///
/// A limit is never above another one's: each lowers the largest current in the direction of motion
/// or against it. So no demand exceeds any limit, whatever the inputs are. Two currents are always
/// allowed against the motion, apart from the thermal limits: the one that the losses of the
/// winding absorb, and that of a shorted winding.
#[derive(Clone, Debug)]
pub struct Limiter {
    supply: Supply,
    voltage: Option<Voltage>,
    current_limit: f32,
    /// Velocity at which no current accelerates the axle any more, rad/s, and A s/rad.
    fastest: f32,
    velocity_slope: f32,
    /// Largest change of the current in a control period, A.
    step: f32,
    winding: Heat,
    bridge: Heat,
    bridge_temperature: Derating,
    motor_temperature: Derating,
    /// The demand of the previous period, A.
    current: f32,
    direct: f32,
}

impl Limiter {
    /// Reads the limits from the settings.
    #[inline(never)] // an inlined copy is longer than a call
    pub fn new(settings: &Settings) -> Self {
        let current_limit = settings.si(Setting::CurrentLimit);
        let velocity_limit = settings.si(Setting::VelocityLimit);
        let band = OVERSPEED - settings.si(Setting::VelocityDerating);
        let heat = |current, time| {
            let continuous = settings.si_or(current, Setting::CurrentLimit);
            Heat::new(continuous, current_limit, settings.si(time))
        };
        let slope = current_limit / settings.si(Setting::TemperatureDerating);
        let derating = |end| Derating {
            end: settings.si(end),
            slope,
        };
        Self {
            supply: Supply::new(settings),
            voltage: Voltage::new(settings),
            current_limit,
            fastest: OVERSPEED * velocity_limit,
            velocity_slope: current_limit / (band * velocity_limit),
            step: CONTROL_PERIOD * settings.si(Setting::CurrentSlope),
            winding: heat(Setting::WindingCurrent, Setting::WindingTime),
            bridge: heat(Setting::BridgeCurrent, Setting::BridgeTime),
            bridge_temperature: derating(Setting::BridgeTemperature),
            motor_temperature: derating(Setting::MotorTemperature),
            current: 0.0,
            direct: 0.0,
        }
    }

    /// Takes over the limits of these settings. Heat and demand stay.
    pub fn retune(&mut self, settings: &Settings) {
        let before = core::mem::replace(self, Self::new(settings));
        self.winding.take_over(&before.winding);
        self.bridge.take_over(&before.bridge);
        if let (Some(voltage), Some(before)) = (&mut self.voltage, &before.voltage) {
            voltage.take_over(before);
        }
        (self.current, self.direct) = (before.current, before.direct);
    }

    /// Returns the heat of winding and bridge in thousandths of what their continuous currents
    /// leave in them.
    pub fn heat(&self) -> [u16; 2] {
        [self.winding.thousandths(), self.bridge.thousandths()]
    }

    /// Returns the demanded currents of the previous control period, A: the one that makes the
    /// torque, and the one in d.
    pub fn demand(&self) -> [f32; 2] {
        [self.current, self.direct]
    }

    /// Advances the thermal models by one control period in which the bridge is off or shorts the
    /// winding, with the measured current, A.
    #[inline]
    pub fn idle(&mut self, current: f32) {
        self.heat_up(current);
        (self.current, self.direct) = (0.0, 0.0);
    }

    /// Limits the current `demand`, A, and advances the thermal models by one control period.
    /// `bound` is the current limit of the present operation, A.
    ///
    /// It is defined for every input. NaN as demand or bound gives 0 A.
    #[inline]
    pub fn limit(&mut self, demand: f32, bound: f32, now: &Conditions) -> Limited {
        self.heat_up(now.current);
        let before = self.current;
        let mut cause = ActiveLimit::None;
        let mut demand = limit(demand, bound);
        let change = limit(demand - self.current, self.step);
        if change != demand - self.current {
            demand = self.current + change;
            cause = ActiveLimit::CurrentSlope;
        }

        let mut side = self.thermal(bound, now);
        let carried = side.bound;
        let (forward, speed) = (now.velocity >= 0.0, now.velocity.abs());
        let braking = |current: f32| if forward { -current } else { current };
        let (along, emf) = (forward == (demand >= 0.0), self.supply.emf(speed));
        let voltage = self.voltage.as_mut().map(|voltage| {
            voltage.at(&Readings {
                speed,
                supply: now.supply_voltage,
                voltage: now.voltage,
                brakes: forward != (now.current >= 0.0),
                excess: positive(braking(now.current) - positive(braking(before))),
            })
        });
        if let Some(voltage) = &voltage {
            side.reduce(voltage.reach(carried, along), ActiveLimit::Voltage);
            if along {
                side.reduce(voltage.accelerating(), ActiveLimit::Voltage);
            }
        }
        self.reduce_by_supply(&mut side, along, emf, now.supply_voltage);
        if along {
            let bound = (self.fastest - speed) * self.velocity_slope;
            side.reduce(bound, ActiveLimit::Speed);
        }
        let current = limit(demand, side.bound);
        if current != demand {
            cause = side.cause;
        }
        self.current = current;
        self.direct = if along || !self.supply.burns {
            0.0
        } else {
            self.burn(current.abs(), emf, carried, now.supply_voltage)
        };
        let weakening = voltage.map_or(0.0, |voltage| voltage.weakening(current.abs(), along));
        if weakening > -self.direct {
            self.add_direct(-weakening, bound, now);
        }
        Limited {
            current,
            direct: self.direct,
            cause,
        }
    }

    /// Returns as much of the current `wanted` in d, A, as all limits leave beside the newest
    /// demand of a three-phase motor. `bound` is the current limit of the present operation, A.
    pub fn add_direct(&mut self, wanted: f32, bound: f32, now: &Conditions) -> f32 {
        if wanted == 0.0 || !(bound > 0.0) {
            return 0.0;
        }
        let Supply { loss, .. } = self.supply;
        let (carried, square) = (self.thermal(bound, now).bound, self.current * self.current);
        let emf = self.supply.emf(now.velocity) * self.current;
        let power = self.supply.motoring(now.supply_voltage, f32::MAX).watts;
        let powered = (power - emf) / loss - square;
        let left = carried * carried - square;
        // NaN leaves nothing.
        let left = if left < powered { left } else { powered };
        let largest = if left > 0.0 { root_of_sum(left) } else { 0.0 };
        self.direct = limit(wanted, largest);
        self.direct
    }

    #[inline]
    fn heat_up(&mut self, measured: f32) {
        let square = measured * measured + self.direct * self.direct;
        self.winding.update(square);
        self.bridge.update(square);
    }

    /// Returns what bridge and winding carry, in both directions.
    #[inline]
    fn thermal(&self, bound: f32, now: &Conditions) -> Side {
        let mut side = Side {
            bound: positive(bound),
            cause: ActiveLimit::VelocityOrCurrent,
        };
        let winding = self.winding.allowed(self.current_limit);
        side.reduce(winding, ActiveLimit::WindingHeat);
        let bridge = self.bridge.allowed(self.current_limit);
        side.reduce(bridge, ActiveLimit::BridgeHeat);
        let bridge = self.bridge_temperature.allowed(now.temperatures.bridge);
        side.reduce(bridge, ActiveLimit::BridgeTemperature);
        let motor = self.motor_temperature.allowed(now.temperatures.motor);
        side.reduce(motor, ActiveLimit::MotorTemperature);
        side
    }

    /// Lowers the bound of a current along the motion, or against it, to what the supply gives and
    /// takes.
    #[inline]
    fn reduce_by_supply(&self, side: &mut Side, along: bool, emf: f32, voltage: f32) {
        let (supply, bound) = (&self.supply, side.bound);
        let taken = (supply.loss * bound + if along { emf } else { -emf }) * bound;
        let power = supply.motoring(voltage, taken);
        if !(taken <= power.watts) {
            let [accelerating, braking] = supply.currents(emf, power.watts);
            side.reduce(if along { accelerating } else { braking }, power.cause);
        }
        if !along {
            let most = emf * bound;
            let power = supply.regenerating(voltage, most);
            let converted = supply.braking(power.watts, bound);
            if !(most <= converted) {
                side.reduce(converted / emf, power.cause);
            }
        }
    }

    /// Returns the current in d, A, that turns the braking power into heat which the supply does
    /// not take back.
    #[inline]
    fn burn(&self, current: f32, emf: f32, carried: f32, voltage: f32) -> f32 {
        let Supply { loss, .. } = self.supply;
        let square = current * current;
        let returned = self.supply.regenerating(voltage, emf * carried).watts;
        let surplus = emf * current - loss * square - returned;
        if !(surplus > 0.0) {
            return 0.0;
        }
        let left = carried * carried - square;
        let burnt = surplus / loss;
        // A negative current in d weakens the field, so that it needs no additional voltage.
        let burnt = if burnt < left { burnt } else { left };
        if burnt > 0.0 {
            -root_of_sum(burnt)
        } else {
            0.0
        }
    }
}
