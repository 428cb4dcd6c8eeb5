//! Reads and writes the operator of a scenario file: the table of a script, or the text `"client"`.

use super::operator::{Operator, chassis_rate};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// The text that makes a client on the bus the operator.
const CLIENT: &str = "client";

impl Operator {
    /// The operator of a scenario in which a client on the bus commands the robot.
    pub fn client() -> Self {
        Self {
            client: true,
            from_power_up: false,
            ..Self::person()
        }
    }

    /// The operator of a run in which a person drives: events are added while it goes on.
    pub fn person() -> Self {
        Self {
            client: false,
            from_power_up: true,
            speed_mps: 0.0,
            chassis_deg: 0.0,
            step_m: 0.0,
            chassis_rate_deg_s: chassis_rate(),
            heading_gain_per_s: 0.0,
            belts: None,
            clearance: None,
            request: None,
            events: Vec::new(),
        }
    }
}

pub(super) fn serialize<S: Serializer>(operator: &Operator, to: S) -> Result<S::Ok, S::Error> {
    if operator.client {
        to.serialize_str(CLIENT)
    } else {
        operator.serialize(to)
    }
}

pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Operator, D::Error> {
    from.deserialize_any(Either)
}

struct Either;

impl<'de> Visitor<'de> for Either {
    type Value = Operator;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the table of a script, or \"{CLIENT}\"")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Operator, E> {
        if text == CLIENT {
            Ok(Operator::client())
        } else {
            Err(E::invalid_value(serde::de::Unexpected::Str(text), &self))
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Operator, A::Error> {
        Operator::deserialize(MapAccessDeserializer::new(table))
    }
}
