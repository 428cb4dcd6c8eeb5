//! An axle program that answers every step with the same: standing still and silent. Tests exchange it for the real one
//! to show that the nodes' programs matter.

use std::io::{Read, Write, stdin, stdout};
use tautrack::link::{FromNode, Ready, Shaft, Stepped, VERSION};

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
        let mut length = [0; 2];
        stdin().read_exact(&mut length)?;
        let mut message = vec![0; usize::from(u16::from_le_bytes(length))];
        stdin().read_exact(&mut message)?;
        let bytes = postcard::to_stdvec(&answer)?;
        stdout().write_all(&(bytes.len() as u16).to_le_bytes())?;
        stdout().write_all(&bytes)?;
        stdout().flush()?;
        answer = FromNode::Stepped(stepped.clone());
    }
}
