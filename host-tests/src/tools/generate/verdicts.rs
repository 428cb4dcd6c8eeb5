//! Writes the table of the guard's verdicts in docs/bus.md as Markdown.

use crate::simulator::run::listener::words;
use std::fmt::Write;
use tautrack::stability::filter::Verdict;

/// Returns the table of verdicts: for each kind its codes, its name in results, and the edges or
/// reasons in the low half of the code.
pub fn table() -> String {
    let mut text = "| Code | In results | Low half |\n|---|---|---|\n".to_owned();
    for kind in 0..=0xf_u8 {
        let found: Vec<(u8, String)> = (0..=0xf)
            .map(|low| kind << 4 | low)
            .filter_map(|code| Some((code, Verdict::from_code(code)?)))
            .filter(|(code, verdict)| verdict.code() == *code)
            .map(|(code, verdict)| (code, words(verdict)))
            .collect();
        let (Some((first, name)), Some((last, _))) = (found.first(), found.last()) else {
            continue;
        };
        // Writing to a string cannot fail.
        let _ = if first == last {
            writeln!(text, "| `{first:#04x}` | {name} | |")
        } else {
            let (name, _) = split(name);
            let named = |(code, words): &(u8, String)| format!("{} {}", code & 0xf, split(words).1);
            let low: Vec<String> = found.iter().map(named).collect();
            let low = low.join(", ");
            writeln!(text, "| `{first:#04x}` to `{last:#04x}` | {name} | {low} |")
        };
    }
    text
}

/// Splits the words of a verdict at the last colon or comma: what happens to the command, and the
/// reason.
fn split(words: &str) -> (&str, &str) {
    let at = words.rfind([':', ',']).unwrap_or(words.len());
    (
        &words[..at],
        words[at..].trim_start_matches([':', ',', ' ']),
    )
}
