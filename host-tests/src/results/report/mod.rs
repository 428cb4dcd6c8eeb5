//! `report.html`: one page that shows a run, without network, on a laptop or a phone.
//!
//! `data` packs the samples, [`channels`] those that only one robot has, `path` the side view; the page draws them: `robots.js` the robot, `scene.js` what is around it, `plots.js` the curves, `page.js` everything else.

pub mod channels;
mod data;
mod path;

use crate::results::summary::Summary;
use crate::scenario::Scenario;
use crate::simulator::record::Sample;

/// The page of one run as a whole.
pub fn html(scenario: &Scenario, summary: &Summary, samples: &[Sample]) -> String {
    // Inside a script element only the start of a tag can end or change the text; a JSON string may write it escaped.
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
        // Last, so that nothing inside the data is taken for a place to fill.
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
