//! CANopen client for settings: expedited SDO transfers, heartbeats, and LSS.

use super::adapter::Adapter;
use super::error::ToolError;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};
use tautrack::bus::{lss, network};
use tautrack::can::Frame;

/// Maximum time for an answer. A save may have to erase flash.
const ANSWER: Duration = Duration::from_secs(2);
/// Time in which every node sends a heartbeat; 1 s is the longest period.
const HEARTBEATS: Duration = Duration::from_millis(1_500);
/// Times that an unanswered request is sent. A request is lost while a node starts.
const ATTEMPTS: usize = 3;

/// Identity of a node (object 0x1018): vendor, product code, revision and serial number.
pub(in crate::tools) type Identity = [u32; 4];

pub(super) struct Client {
    adapter: Adapter,
}

impl Client {
    pub fn open(address: &str) -> Result<Self, ToolError> {
        Ok(Self {
            adapter: Adapter::open(address)?,
        })
    }

    /// Returns the ids of all nodes that send heartbeats.
    pub fn nodes(&mut self) -> Result<BTreeSet<u8>, ToolError> {
        let deadline = Instant::now() + HEARTBEATS;
        let mut nodes = BTreeSet::new();
        while let Some(frame) = self.adapter.receive(deadline)? {
            nodes.extend(network::as_heartbeat(&frame).map(|(node, _)| node));
        }
        Ok(nodes)
    }

    /// Ends the configuration of blank nodes that another run began: two nodes in configuration
    /// would take the same id.
    pub fn end_configuration(&mut self) -> Result<(), ToolError> {
        self.send(lss::REQUEST, [4, 0, 0, 0, 0, 0, 0, 0])
    }

    /// Reads an object of four bytes.
    pub fn read(&mut self, node: u8, index: u16, sub: u8) -> Result<u32, ToolError> {
        self.transfer(node, 0x40, index, sub, 0)
    }

    /// Writes an object of four bytes.
    pub fn write(&mut self, node: u8, index: u16, sub: u8, value: u32) -> Result<(), ToolError> {
        self.transfer(node, 0x23, index, sub, value).map(|_| ())
    }

    fn transfer(
        &mut self,
        node: u8,
        command: u8,
        index: u16,
        sub: u8,
        value: u32,
    ) -> Result<u32, ToolError> {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        let request = [command, low, high, sub, a, b, c, d];
        let answer = 0x580 + u16::from(node);
        let found = self.ask(0x600 + u16::from(node), request, |frame| {
            frame.id() == answer && frame.data().get(1..4) == Some(&[low, high, sub])
        })?;
        let Some([command, _, _, _, a, b, c, d]) = found else {
            return Err(ToolError::Silent { node, index, sub });
        };
        let value = u32::from_le_bytes([a, b, c, d]);
        if command == 0x80 {
            return Err(ToolError::Aborted {
                node,
                index,
                sub,
                code: value,
            });
        }
        Ok(value)
    }

    pub fn identity(&mut self, node: u8) -> Result<Identity, ToolError> {
        let mut identity = [0; 4];
        for (sub, number) in (1..).zip(&mut identity) {
            *number = self.read(node, 0x1018, sub)?;
        }
        Ok(identity)
    }

    /// Gives the blank node with this identity the id `node`, and starts it.
    pub fn configure(&mut self, node: u8, identity: Identity) -> Result<(), ToolError> {
        let is_answer = |command: u8| {
            move |frame: &Frame| {
                frame.id() == lss::RESPONSE && frame.data().first() == Some(&command)
            }
        };
        for (command, number) in (0x40..).zip(&identity[..3]) {
            self.send(lss::REQUEST, with_number(command, *number))?;
        }
        let serial = identity[3];
        let selected = self.ask(lss::REQUEST, with_number(0x43, serial), is_answer(0x44))?;
        if selected.is_none() {
            return Err(ToolError::NoBlankNode { node, serial });
        }
        // Node id, then save.
        for request in [[0x11, node, 0, 0, 0, 0, 0, 0], [0x17, 0, 0, 0, 0, 0, 0, 0]] {
            let answer = self.ask(lss::REQUEST, request, is_answer(request[0]))?;
            let error = answer.map_or(u8::MAX, |answer| answer[1]);
            if error != 0 {
                return Err(ToolError::NotConfigured { node, error });
            }
        }
        self.end_configuration()
    }

    fn send(&mut self, id: u16, data: [u8; 8]) -> Result<(), ToolError> {
        match Frame::new(id, &data) {
            Some(frame) => self.adapter.send(&frame),
            None => Ok(()), // every identifier here has 11 bits
        }
    }

    /// Sends a request until a frame is the answer. Returns the data of the answer.
    fn ask(
        &mut self,
        id: u16,
        data: [u8; 8],
        is_answer: impl Fn(&Frame) -> bool,
    ) -> Result<Option<[u8; 8]>, ToolError> {
        for _ in 0..ATTEMPTS {
            self.send(id, data)?;
            let deadline = Instant::now() + ANSWER;
            while let Some(frame) = self.adapter.receive(deadline)? {
                if is_answer(&frame)
                    && let Ok(data) = frame.data().try_into()
                {
                    return Ok(Some(data));
                }
            }
        }
        Ok(None)
    }
}

fn with_number(command: u8, number: u32) -> [u8; 8] {
    let [a, b, c, d] = number.to_le_bytes();
    [command, a, b, c, d, 0, 0, 0]
}
