//! `cargo demo --page`: makes the page on the web, one file with the module of simulator and nodes
//! ([`crate::live`]). It needs neither a server nor a network.
//!
//! `page.html` is its frame, `worker.js` runs the module, `drive.js` drives the run, `panel.js`
//! shows the nodes on the bus from the [`tables`], `canopen.js` is their client and `slcan.js` the
//! protocol of an adapter. The scene is in `results`.
//! [`compare`] makes a page that shows two runs of a scenario.

pub mod compare;
mod tables;

use crate::programs::setup::build::page_module;
use crate::programs::setup::checkout;
use crate::results::scene::SCRIPTS;
use crate::results::scene::pack::packed;
use crate::robots::Kind;
use crate::tools::robot;
use clap::ValueEnum;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// Name of the file.
const FILE: &str = "page.html";

/// Writes the page into a folder. Returns its path.
///
/// # Errors
/// A text for the user.
pub fn write(folder: &Path) -> Result<PathBuf, String> {
    let module = page_module().map_err(|error| error.to_string())?;
    let path = folder.join(FILE);
    let fail = |path: &Path| {
        let path = path.display().to_string();
        move |error: std::io::Error| format!("{path}: {error}")
    };
    let bytes = fs::read(&module).map_err(fail(&module))?;
    let page = page(&bytes)?;
    fs::create_dir_all(folder).map_err(fail(folder))?;
    fs::write(&path, page).map_err(fail(&path))?;
    Ok(path)
}

fn page(module: &[u8]) -> Result<String, String> {
    let module = packed(module);
    let places = in_script(&places()?);
    let tables = tables::tables().map_err(|error| error.to_string())?;
    let tables = in_script(&tables);
    let canopen = include_str!("canopen.js");
    let worker = format!("{canopen}\n{}", include_str!("worker.js"));
    let [gl, scene] = SCRIPTS;
    let parts = [
        ("{{style}}", include_str!("page.css")),
        ("{{places}}", &places),
        ("{{tables}}", &tables),
        ("{{worker}}", &worker),
        ("{{canopen}}", canopen),
        ("{{slcan}}", include_str!("slcan.js")),
        ("{{gl}}", gl),
        ("{{robot}}", scene),
        ("{{panel}}", include_str!("panel.js")),
        ("{{drive}}", include_str!("drive.js")),
        ("{{module}}", &module),
    ];
    let page = include_str!("page.html").to_owned();
    Ok(parts
        .iter()
        .fold(page, |page, (place, text)| page.replace(place, text)))
}

/// Writes JSON inside a script element, where `<` could end it.
fn in_script(value: &Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

/// Robots and grounds with the text of their scenarios. The first one is shown first.
fn places() -> Result<Value, String> {
    let root = checkout::root().map_err(|error| error.to_string())?;
    let mut places = Vec::new();
    for kind in Kind::value_variants() {
        for (ground, file) in robot::places(*kind) {
            let path = root.join("host-tests/scenarios").join(file);
            let text = fs::read_to_string(&path)
                .map_err(|error| format!("{}: {error}", path.display()))?;
            let robot = kind.facts().name;
            places.push(json!({ "robot": robot, "ground": ground, "text": text }));
        }
    }
    Ok(places.into())
}
