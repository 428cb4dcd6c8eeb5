//! Several nodes on one emulated machine, which take turns.
//!
//! Emulators beside each other displace each other's translated code from the processor's caches,
//! and then take more than twice the time. Nodes on one machine share the translated code. They run
//! the same program and are idle between two messages, so a node is what its static variables hold.
//!
//! The largest of these variables, in the section `.seldom`, are exchanged only for a node that
//! needs them at that time.

use super::semihosting::Stream;
use crate::boards::lockstep::keeps_seldom;
use core::slice;

/// Maximum number of nodes in the life of a machine.
const NODES: usize = 1 + u8::MAX as usize;

unsafe extern "C" {
    /// First address of the static variables, end of those in `.seldom`, and end of all, from the
    /// link script.
    static mut __sdata: u8;
    static mut __eseldom: u8;
    static mut __ebss: u8;
}

/// Static variables of the nodes whose turn it is not.
pub struct Turns {
    file: Stream,
    /// Node to which the variables in memory belong. [`NODES`] stands for a node before its first
    /// message, which all nodes are equal to.
    current: usize,
    /// Number of nodes that have had a message.
    started: usize,
    /// Nodes whose variables in `.seldom` are in the file. The last one is that before its first
    /// message.
    seldom: [bool; NODES + 1],
}

impl Turns {
    /// No node has had a message. `None` if the host has no room for temporary files.
    pub fn new() -> Option<Self> {
        Some(Self {
            file: Stream::temporary()?,
            current: NODES,
            started: 0,
            seldom: [false; NODES + 1],
        })
    }

    /// Exchanges the static variables for those of `node`. Numbers begin at 0 and leave none out.
    /// Returns `false` for other numbers, and if the file fails.
    ///
    /// # Safety
    /// No static variable is borrowed, except by references that the nodes have in common.
    pub unsafe fn turn_to(&mut self, node: u8) -> bool {
        let next = usize::from(node);
        if next == self.current {
            return true;
        }
        let from = if next < self.started { next } else { NODES };
        if next > self.started {
            return false;
        }
        let keeps = self.current == NODES || keeps_seldom();
        self.seldom[self.current] = keeps;
        let start = &raw mut __sdata;
        let length = &raw mut __ebss as usize - start as usize;
        let often = &raw mut __eseldom as usize - start as usize;
        // SAFETY: the link script puts the static variables there, and by the contract of this
        // function nothing else refers to them.
        let variables = unsafe { slice::from_raw_parts_mut(start, length) };
        let begin = |seldom: bool| if seldom { 0 } else { often };

        let place = begin(keeps);
        let mut exchanged = self.file.seek(self.current * length + place)
            && self.file.write_all(&variables[place..]);
        // In `.seldom` there are still the variables of the node that leaves.
        if keeps && !self.seldom[from] {
            exchanged &=
                self.file.seek(NODES * length) && self.file.read_exact(&mut variables[..often]);
        }
        let place = begin(self.seldom[from]);
        exchanged &=
            self.file.seek(from * length + place) && self.file.read_exact(&mut variables[place..]);
        self.current = next;
        self.started = self.started.max(next + 1);
        exchanged
    }
}
