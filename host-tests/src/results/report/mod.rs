//! Makes `report.html`: one page that shows a run, on a laptop or a phone, without network access.
//!
//! [`Page`] collects what the page shows while the run goes on, with the curves of `columns` and
//! [`channels`], the side view of `path`, the 3-D scene of `pictures` and the `marks` of the time
//! line. `decimation` bounds its memory, `data` packs it. In the page `solid.js` shows the scene.
//! For paper, and where a browser cannot draw the scene, `sketch.js` or the robot's own script
//! draws the robot from the side, and `scene.js` its surroundings. `plots.js` draws the curves,
//! and `page.js` does everything else.

pub mod channels;
mod columns;
mod data;
pub mod decimation;
mod marks;
mod page;
mod path;
mod pictures;

use page::Drawing;

pub use columns::Source;
pub use page::{AxlesOf, OwnPage, Page};

use crate::results::scene::SCRIPTS;
use crate::results::summary::Summary;
use crate::scenario::Scenario;
use crate::simulator::record::Sample;
use std::io::{self, Write};

/// The complete page of a run whose samples are in memory.
///
/// # Errors
/// As [`Page::write`].
pub fn html(scenario: &Scenario, summary: &Summary, samples: &[Sample]) -> io::Result<String> {
    let mut page = Page::new(scenario);
    for sample in samples {
        page.add(sample);
    }
    let mut text = Vec::new();
    page.write(scenario, summary, &mut text)?;
    String::from_utf8(text).map_err(io::Error::other)
}

impl Page {
    /// Writes the complete page of a run that ends now.
    ///
    /// # Errors
    /// When `out` cannot be written.
    pub fn write(
        mut self,
        scenario: &Scenario,
        summary: &Summary,
        mut out: impl Write,
    ) -> io::Result<()> {
        let script = match &self.drawing {
            Drawing::Own(own) => own.script,
            Drawing::Sketch(_) => include_str!("sketch.js"),
        };
        let data = data::pack(&mut self, scenario, summary);
        let frame = frame(scenario, script);
        let (before, after) = frame.split_once("{{data}}").unwrap_or_default();
        out.write_all(before.as_bytes())?;
        serde_json::to_writer(Escaped(&mut out), &data)?;
        out.write_all(after.as_bytes())
    }
}

/// The page with the script of the robot and a place for its data.
fn frame(scenario: &Scenario, script: &str) -> String {
    let title = escape(&scenario.name);
    let [gl, shapes] = SCRIPTS;
    let parts = [
        ("{{title}}", title.as_str()),
        ("{{style}}", include_str!("page.css")),
        ("{{robot}}", script),
        ("{{scene}}", include_str!("scene.js")),
        ("{{gl}}", gl),
        ("{{shapes}}", shapes),
        ("{{solid}}", include_str!("solid.js")),
        ("{{plots}}", include_str!("plots.js")),
        ("{{page}}", include_str!("page.js")),
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

/// Writes JSON into a script element. There only `<` can begin a tag that ends or changes the
/// script. JSON allows it to be escaped inside a string, and has it nowhere else.
struct Escaped<W>(W);

impl<W: Write> Write for Escaped<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        for (index, part) in bytes.split(|byte| *byte == b'<').enumerate() {
            if index > 0 {
                self.0.write_all(b"\\u003c")?;
            }
            self.0.write_all(part)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}
