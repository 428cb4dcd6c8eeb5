//! Splits the name of a robot-specific channel into title, place and unit: `front_left_load_n` is
//! the load in N at the front left.
//!
//! The last word of a name is the unit. Words such as "front" and "left" say where on the robot the
//! channel is measured.

/// Words that say where on the robot a channel is measured.
const PLACES: [&str; 5] = ["front", "rear", "middle", "left", "right"];

/// Title, place and unit of a channel, taken from its name.
pub struct Channel {
    /// What the channel measures.
    pub title: String,
    /// Where on the robot it is measured; empty if it concerns the whole robot.
    pub place: String,
    /// Its unit, as reports print it; "1" for a pure number.
    pub unit: &'static str,
}

impl Channel {
    /// Splits a name from [`crate::world::truth::Truth::channels`].
    pub fn new(name: &str) -> Self {
        let (words, suffix) = name.rsplit_once('_').unwrap_or((name, ""));
        let (places, words): (Vec<_>, Vec<_>) =
            words.split('_').partition(|word| PLACES.contains(word));
        let mut title = words.join(" ");
        if let Some(first) = title.get_mut(..1) {
            first.make_ascii_uppercase();
        }
        Self {
            title,
            place: places.join(" "),
            unit: unit(suffix),
        }
    }
}

impl Channel {
    /// The unit with a space before it, to follow a number; empty for a pure number.
    pub fn suffix(&self) -> String {
        if self.unit == "1" {
            String::new()
        } else {
            format!(" {}", self.unit)
        }
    }

    /// Title and place in one text.
    pub fn name(&self) -> String {
        let comma = if self.place.is_empty() { "" } else { ", " };
        format!("{}{comma}{}", self.title, self.place)
    }
}

fn unit(suffix: &str) -> &'static str {
    match suffix {
        "m" => "m",
        "mm" => "mm",
        "mps" => "m/s",
        "rad" => "rad",
        "deg" => "°",
        "radps" => "rad/s",
        "n" => "N",
        "nm" => "N m",
        "a" => "A",
        _ => "1",
    }
}
