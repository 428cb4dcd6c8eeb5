//! Writes the generated parts of docs/faults.md and docs/settings.md as Markdown.

use std::fmt::Write;
use tautrack::faults::{self, Reaction};
use tautrack::settings::{self, Effect};

/// Returns the tables of docs/faults.md: an overview, and one section for each fault.
pub fn faults() -> String {
    let mut text = "| Code | Fault | Reaction of the drive | Time, seen | Counted from |\n\
        |---|---|---|---|---|\n"
        .to_owned();
    let reaction = |reaction| match reaction {
        Reaction::Hold => "ramps to standstill and holds",
        Reaction::Brake => "brakes",
        Reaction::Off => "opens its bridge",
    };
    for row in faults::TABLE {
        let (code, name, does) = (row.code, row.name, reaction(row.reaction));
        let (time, from) = (row.longest_ms, in_italics(row.from));
        let _ = writeln!(
            text,
            "| `0x{code:04X}` | {name} | {does} | {time} ms | {from} |"
        );
    }
    for row in faults::TABLE {
        let points = [
            format!("* Cleared by: {}.", row.clears),
            format!("* Remedy: {}", in_italics(row.remedy)),
        ];
        let points = points.map(|point| wrapped(&point, "  ")).join("\n");
        let (code, name, cause) = (row.code, row.name, wrapped(&in_italics(row.cause), ""));
        let _ = write!(text, "\n### 0x{code:04X} {name}\n\n{cause}\n\n{points}\n");
    }
    text
}

/// Sets the names of settings in italics.
pub fn in_italics(text: &str) -> String {
    let names = settings::TABLE.iter().map(|row| row.name);
    names.fold(text.to_owned(), |text, name| {
        text.replace(&format!("`{name}`"), &format!("*{name}*"))
    })
}

/// Breaks `text` into lines of at most 100 columns; those after the first begin with `indent`.
fn wrapped(text: &str, indent: &str) -> String {
    let (mut wrapped, mut columns) = (String::new(), 0);
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if columns > 0 && columns + 1 + length > 100 {
            wrapped.push('\n');
            wrapped.push_str(indent);
            columns = indent.len();
        } else if columns > 0 {
            wrapped.push(' ');
            columns += 1;
        }
        wrapped.push_str(word);
        columns += length;
    }
    wrapped
}

/// Groups of settings: the last key of each group, and its title with the roles that read it.
const GROUPS: &[(u16, &str)] = &[
    (0x000f, "Every node"),
    (0x002f, "Motor and output shaft: axle, screw"),
    (0x003f, "Belt: screw, guard"),
    (0x005f, "Robot and operator: guard"),
    (0x006f, "Compass: guard"),
    (0x007f, "Margins, trip and trust: guard"),
    (0x008f, "Crawler: guard"),
    (0x009f, "Other robots: guard"),
    (0x00af, "Sensors: guard"),
    (0x00bf, "Masses of B2P2: guard"),
    (0x00cf, "Three-phase motor: axle, screw"),
    (0x00df, "Limits: axle, screw"),
    (0x00ef, "Stops, windows and brake: axle, screw"),
];

/// Returns the tables of docs/settings.md: one for each group of settings.
pub fn settings() -> String {
    let mut text = String::new();
    let mut first = 0;
    let listed = settings::TABLE
        .iter()
        .all(|row| GROUPS.iter().any(|(last, _)| row.key <= *last));
    assert!(listed, "a setting is in no group");
    for &(last, title) in GROUPS {
        let _ = write!(
            text,
            "### {title}\n\n| Key | Name | Unit | From | To | Default | Takes effect | Meaning |\n|---|---|---|---|---|---|---|---|\n"
        );
        for (row, meaning) in settings::TABLE.iter().zip(settings::MEANINGS) {
            if (first..=last).contains(&row.key) {
                let _ = writeln!(
                    text,
                    "| `{:#06x}` | `{}` | {} | {} | {} | {} | {} | {} |",
                    row.key,
                    row.name,
                    row.unit,
                    row.minimum,
                    row.maximum,
                    row.default,
                    effect(row.effect),
                    sentence(meaning)
                );
            }
        }
        text.push('\n');
        first = last + 1;
    }
    text.truncate(text.trim_end().len());
    text.push('\n');
    text
}

/// Says when a written value takes effect in a drive.
pub fn effect(effect: Effect) -> &'static str {
    match effect {
        Effect::Restart => "after a restart",
        Effect::Gain => "at once",
        Effect::Limit => "at once; while armed, only a lower one",
        Effect::Disarmed => "at once, but refused while armed",
    }
}

/// Converts a doc comment to a sentence of a page: removes the brackets of rustdoc links.
pub fn sentence(comment: &str) -> String {
    comment.trim().replace("[`", "`").replace("`]", "`")
}
