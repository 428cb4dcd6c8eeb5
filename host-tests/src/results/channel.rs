//! A robot's own channels by their names: `front_left_load_n` is the load in N at the front left.
//!
//! The last word is the unit, words of place say where it is.

/// Words that say where on the robot a channel is.
const PLACES: [&str; 5] = ["front", "rear", "middle", "left", "right"];

/// A channel's name taken apart.
pub struct Channel {
    /// What it is.
    pub title: String,
    /// Where it is; empty when it is of the whole robot.
    pub place: String,
    /// Its unit as written on a page.
    pub unit: &'static str,
}

impl Channel {
    /// Of a name in [`crate::world::truth::Truth::channels`].
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
    /// The unit as it follows a number; nothing for a pure number.
    pub fn suffix(&self) -> String {
        if self.unit == "1" {
            String::new()
        } else {
            format!(" {}", self.unit)
        }
    }

    /// What and where in one.
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
