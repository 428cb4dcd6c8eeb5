//! Faults and settings as Markdown.

use std::fmt::Write;
use tautrack::faults::{self, Reaction};
use tautrack::settings;

/// Overview and one section per fault.
pub fn faults() -> String {
    let mut text = "| Code | Fault | The axle |\n|---|---|---|\n".to_owned();
    let reaction = |reaction| match reaction {
        Reaction::Hold => "ramps to standstill and holds",
        Reaction::Brake => "shorts its windings",
        Reaction::Off => "opens its bridge",
    };
    for row in faults::TABLE {
        let (code, name, does) = (row.code, row.name, reaction(row.reaction));
        let _ = writeln!(text, "| `{code:#06x}` | {name} | {does} |");
    }
    for row in faults::TABLE {
        let _ = write!(
            text,
            "\n### {:#06x} {}\n\n{}\n\n* Reaction: the axle {}.\n* Clears by: {}.\n* What to do: {}\n",
            row.code,
            row.name,
            row.cause,
            reaction(row.reaction),
            row.clears,
            row.remedy
        );
    }
    text
}

/// Groups of settings: the last key of each, and who reads them.
const GROUPS: &[(u16, &str)] = &[
    (0x000f, "Every node"),
    (0x002f, "The motor and its axle: axle and screw"),
    (0x003f, "The belt and its screw: screw and guard"),
    (0x005f, "The robot: guard"),
    (0x006f, "The sensors on the body: guard"),
    (0x007f, "Balance, trip and trust: guard"),
    (0x008f, "The crawler: guard"),
    (0x009f, "Robots whose drives have consecutive ids: guard"),
    (0x00bf, "Masses of B2P2: guard"),
];

/// One table per group.
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
            "### {title}\n\n| Key | Name | Unit | From | To | Default | Meaning |\n|---|---|---|---|---|---|---|\n"
        );
        for (row, meaning) in settings::TABLE.iter().zip(settings::MEANINGS) {
            if (first..=last).contains(&row.key) {
                let _ = writeln!(
                    text,
                    "| `{:#06x}` | `{}` | {} | {} | {} | {} | {} |",
                    row.key,
                    row.name,
                    row.unit,
                    row.minimum,
                    row.maximum,
                    row.default,
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

/// A documentation comment outside of rustdoc: without the brackets of its links.
pub fn sentence(comment: &str) -> String {
    comment.trim().replace("[`", "`").replace("`]", "`")
}
