//! Launches a node from its program, board and start message. These are stored, so that the node
//! can be restarted.

use super::Options;
use super::flash::Flash;
use super::node::{Node, NodeError};
use crate::programs::{Board, Program, Programs};
use crate::robots::{NodeName, NodeSpec};
use std::time::Duration;
use tautrack::link::{MAX_SETTINGS, Ready, Start, VERSION};
use tautrack::settings::Setting;

/// Everything needed to start one node.
pub struct Launch {
    name: NodeName,
    board: Board,
    program: Program,
    start: Start,
    timeout: Option<Duration>,
}

impl Launch {
    /// Creates the launch of the node `spec`. `options` may replace its program and set its
    /// timeout; its flash is in `flash`, and `seed` is the seed of its noise.
    pub fn new(
        spec: &NodeSpec,
        programs: &Programs,
        options: &Options,
        flash: &Flash,
        seed: u64,
    ) -> Self {
        let (board, program) = program_of(spec, programs, &options.exchanged);
        Self {
            name: spec.name,
            board,
            program: program.clone(),
            start: Start {
                version: VERSION,
                seed,
                flash: flash.file(spec.name),
                settings: if options.blank {
                    heapless::Vec::new()
                } else {
                    settings(spec)
                },
                motor: spec.motor,
                role: spec.role.name().try_into().unwrap_or_default(),
            },
            timeout: options.node_timeout,
        }
    }

    /// Starts the node; each start is the same.
    ///
    /// # Errors
    /// Those of [`Node::start`].
    pub fn start(&self) -> Result<(Node, Ready), NodeError> {
        let path = &self.program.path;
        let (mut node, ready) = Node::start(self.name, self.board, path, self.start.clone())?;
        if let Some(timeout) = self.timeout {
            node.set_timeout(timeout);
        }
        Ok((node, ready))
    }

    /// SHA-256 of the program, hexadecimal.
    pub fn program_sha256(&self) -> &str {
        &self.program.sha256
    }
}

/// Returns a node's settings as pairs of key and value.
fn settings(spec: &NodeSpec) -> heapless::Vec<(u16, i32), MAX_SETTINGS> {
    let id = (Setting::NodeId, i32::from(spec.id));
    std::iter::once(&id)
        .chain(&spec.settings)
        .map(|(setting, value)| (setting.description().key, *value))
        .collect()
}

fn program_of<'a>(
    spec: &NodeSpec,
    programs: &'a Programs,
    exchanged: &'a [(NodeName, Board, Program)],
) -> (Board, &'a Program) {
    let exchanged = exchanged.iter().find(|(of, ..)| *of == spec.name);
    exchanged.map_or((programs.board, &programs.nodes), |(_, board, program)| {
        (*board, program)
    })
}
