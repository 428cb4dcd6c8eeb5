//! Prepares a run before anything is built, so that errors show at once: reads the scenario, opens
//! the port for CAN clients and the folder of the results.

use super::arguments::{Arguments, Switch};
use super::images;
use super::output::Output;
use crate::programs::setup::checkout;
use crate::robots::{NodeName, Role};
use crate::scenario::Scenario;
use crate::simulator::slcan::SlcanPort;
use std::path::{Path, PathBuf};
use tautrack::link::MAX_PATH;

/// Bytes of the longest name of a file in the folder of the flash, with the separator.
const FILE_NAME: usize = 32;

/// Everything that a run needs, checked and opened.
pub(super) struct Prepared {
    pub scenario: Scenario,
    pub slcan: Option<SlcanPort>,
    pub output: Output,
    /// Absolute path of the folder with the nodes' flash.
    pub flash: Option<String>,
    /// Nodes that run a flash image.
    pub images: Vec<(NodeName, Role)>,
}

impl Prepared {
    pub fn new(arguments: &Arguments, out: &Path) -> Result<Self, String> {
        let scenario = scenario(arguments)?;
        if scenario.operator.client && arguments.slcan.is_none() {
            let why = "a CAN client is the operator; add --slcan 127.0.0.1:3333 (docs/bus.md)";
            return Err(format!("{}: {why}", scenario.name));
        }
        let slcan = arguments.slcan.as_ref().map(|address| {
            SlcanPort::bind(address)
                .map_err(|error| format!("cannot listen on --slcan {address} (ADDR:PORT): {error}"))
        });
        let images = images::nodes(&arguments.image, &scenario.nodes())?;
        Ok(Self {
            images,
            scenario,
            slcan: slcan.transpose()?,
            flash: arguments.flash.as_deref().map(flash).transpose()?,
            output: Output::open(out)
                .map_err(|error| format!("cannot write to --out {}: {error}", out.display()))?,
        })
    }
}

/// Creates the folder for the nodes' flash; returns its absolute path.
fn flash(folder: &Path) -> Result<String, String> {
    let fail = |why: String| format!("cannot use --flash {}: {why}", folder.display());
    std::fs::create_dir_all(folder).map_err(|error| fail(error.to_string()))?;
    let path = folder
        .canonicalize()
        .map_err(|error| fail(error.to_string()))?;
    let longest = MAX_PATH - FILE_NAME;
    match path.to_str() {
        Some(path) if path.len() <= longest => Ok(path.to_owned()),
        _ => Err(fail(format!(
            "its path must be UTF-8 of at most {longest} bytes"
        ))),
    }
}

fn root() -> Result<&'static Path, String> {
    checkout::root().map_err(|error| error.to_string())
}

/// The folder of the results. The default is given relative to the working directory if it is below
/// it.
pub(super) fn folder(arguments: &Arguments) -> Result<PathBuf, String> {
    if let Some(out) = &arguments.out {
        return Ok(out.clone());
    }
    let folder = root()?.join("target/demo");
    let here = std::env::current_dir().unwrap_or_default();
    let short = folder.strip_prefix(here).map(Path::to_owned);
    Ok(short.unwrap_or(folder))
}

/// The path of the scenario's file. A path from the checkout's root, as the docs give it, is also
/// found from another directory.
fn scenario_file(arguments: &Arguments) -> Result<PathBuf, String> {
    let Some(path) = &arguments.scenario else {
        let shipped = root()?.join("host-tests/scenarios");
        return Ok(shipped.join(arguments.robot.facts().scenario_file));
    };
    if !path.exists()
        && let Ok(from_root) = root().map(|root| root.join(path))
        && from_root.exists()
    {
        return Ok(from_root);
    }
    Ok(path.clone())
}

pub(super) fn scenario(arguments: &Arguments) -> Result<Scenario, String> {
    let path = scenario_file(arguments)?;
    let scenario = Scenario::load(&path).map_err(|error| error.to_string())?;
    let mut description = scenario.description();
    if let Some(guard) = arguments.guard {
        description.guard = matches!(guard, Switch::On);
    }
    if !description.guard {
        // The expectation about interventions does not apply if the guard is off.
        description.expect.guard_intervenes = None;
    }
    description.sensors = arguments.sensors(description.sensors);
    description.seed = arguments.seed.unwrap_or(description.seed);
    description
        .check()
        .map_err(|problem| format!("{}: {problem}", path.display()))
}
