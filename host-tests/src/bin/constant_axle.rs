//! An axle program that answers every step with the same message: the axle stands still and sends
//! nothing. Tests run it in place of the real program to show that a run depends on the nodes'
//! programs.

use std::io::{Read, Write, stdin, stdout};
use tautrack::link::{FromNode, PREFIX, Ready, Shaft, Stepped, VERSION};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ready = Ready {
        version: VERSION,
        role: "axle".try_into()?,
        board: "constant".try_into()?,
        refusal: "".try_into()?,
    };
    let stepped = Stepped {
        shaft: Shaft::default(),
        frames: heapless::Vec::new(),
        log: heapless::Vec::new(),
    };
    let mut answer = FromNode::Ready(ready);
    loop {
        let mut prefix = [0; PREFIX];
        stdin().read_exact(&mut prefix)?;
        let [low, high, node] = prefix;
        let mut message = vec![0; usize::from(u16::from_le_bytes([low, high]))];
        stdin().read_exact(&mut message)?;
        let bytes = postcard::to_stdvec(&answer)?;
        stdout().write_all(&(bytes.len() as u16).to_le_bytes())?;
        stdout().write_all(&[node])?;
        stdout().write_all(&bytes)?;
        stdout().flush()?;
        answer = FromNode::Stepped(stepped.clone());
    }
}
