//! What is counted of each robot: its guard's ticks, and functions of its model.

mod b2p2;
mod crawler;
mod hylos;
mod rt_mover;

use super::counter::Table;

macro_rules! counts {
    ($($folder:ident::$body:ident: $about:literal,)*) => {
        /// Counts every robot.
        pub fn count(table: &mut Table) -> Option<()> {
            $($folder::count(table)?;)*
            Some(())
        }
    };
}

tautrack::every_robot!(counts);
