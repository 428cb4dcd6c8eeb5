//! An axle program that answers every step with the same message: the axle stands still and sends
//! nothing. Tests run it in place of the real program to show that a run depends on the nodes'
//! programs.

use std::io::{Read, Write, stdin, stdout};
use tautrack::link::{FromNode, Prefix, Ready, Shaft, Stepped, VERSION};

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
        let mut prefix = [0; Prefix::BYTES];
        stdin().read_exact(&mut prefix)?;
        let Prefix { length, node } = Prefix::from_bytes(prefix);
        let mut message = vec![0; usize::from(length)];
        stdin().read_exact(&mut message)?;
        let bytes = postcard::to_stdvec(&answer)?;
        let length = bytes.len() as u16;
        stdout().write_all(&Prefix { length, node }.to_bytes())?;
        stdout().write_all(&bytes)?;
        stdout().flush()?;
        answer = FromNode::Stepped(stepped.clone());
    }
}
