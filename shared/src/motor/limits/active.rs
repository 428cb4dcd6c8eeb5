//! The list of limits that object 0x2000 shows.

/// Limit that keeps the axle from following its set-point exactly (object 0x2000).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum ActiveLimit {
    /// No limit.
    None = 0,
    /// The velocity limit or the current limit.
    VelocityOrCurrent = 1,
    /// An end of the travel in the settings.
    Travel = 2,
    /// A limit switch.
    Switch = 3,
    /// The axle is not homed yet.
    NotHomed = 4,
    /// The current that the supply gives (`supply_current_limit`).
    SupplyCurrent = 5,
    /// The current that the supply takes back (`regeneration_current_limit`).
    RegenerationCurrent = 6,
    /// The supply voltage is below `motoring_voltage`.
    LowSupplyVoltage = 7,
    /// The supply voltage is above `regeneration_voltage`.
    HighSupplyVoltage = 8,
    /// The electrical power (`power_limit`).
    Power = 9,
    /// The speed is near "overspeed" (`velocity_derating`).
    Speed = 10,
    /// The change of the current per time (`current_slope`).
    CurrentSlope = 11,
    /// The heat of the winding (`winding_current`).
    WindingHeat = 12,
    /// The heat of the bridge (`bridge_current`).
    BridgeHeat = 13,
    /// The measured temperature of the bridge.
    BridgeTemperature = 14,
    /// The measured temperature of the motor.
    MotorTemperature = 15,
    /// The rotor is being aligned before operation is enabled.
    Alignment = 16,
    /// The shaft has not yet turned the way of its torque since power was enabled
    /// (`probe_current`).
    SignProbe = 17,
    /// The voltage of the bridge does not suffice for a higher speed, or for more torque at this
    /// speed.
    Voltage = 18,
    /// The belt has not the commanded slack: it is above `slack_limit`, or the screw is at its
    /// released length.
    Slack = 19,
}
