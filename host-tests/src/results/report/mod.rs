//! Makes `report.html`: one page that shows a run, on a laptop or a phone, without network access.
//!
//! `data` packs the samples, [`channels`] the robot-specific channels, `path` the side view. In the
//! page `robots.js` draws the robot, `scene.js` its surroundings, `plots.js` the curves, and
//! `page.js` everything else.

pub mod channels;
mod data;
mod path;

use crate::results::summary::Summary;
use crate::scenario::Scenario;
use crate::simulator::record::Sample;

/// The complete page of one run.
pub fn html(scenario: &Scenario, summary: &Summary, samples: &[Sample]) -> String {
    // Inside a script element only `<` can begin a tag that ends or changes the script. JSON allows
    // it to be escaped inside a string.
    let data = data::pack(scenario, summary, samples)
        .to_string()
        .replace('<', "\\u003c");
    let title = escape(&scenario.name);
    let parts = [
        ("{{title}}", title.as_str()),
        ("{{style}}", include_str!("page.css")),
        ("{{robots}}", include_str!("robots.js")),
        ("{{scene}}", include_str!("scene.js")),
        ("{{plots}}", include_str!("plots.js")),
        ("{{page}}", include_str!("page.js")),
        // The data come last, so that no text in them is replaced as a placeholder.
        ("{{data}}", data.as_str()),
    ];
    parts.iter().fold(
        include_str!("page.html").to_owned(),
        |page, (place, text)| page.replace(place, text),
    )
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
