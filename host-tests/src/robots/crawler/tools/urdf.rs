//! The crawler: one link. Its belts are no links; their motors move no joint.

use crate::robots::crawler::plant::{CrawlerParameters, MassProperties};
use crate::tools::generate::urdf::Description;
use crate::world::inertia::Inertia;
use std::collections::BTreeMap;

pub fn links() -> Description {
    let properties = MassProperties::new(&CrawlerParameters::nominal(), None);
    let inertia = Inertia {
        mass: properties.mass,
        centre: properties.cog,
        about_centre: properties.inertia,
    };
    let body = "body".to_owned();
    Description {
        root: body.clone(),
        joints: Vec::new(),
        masses: [(body, inertia)].into(),
        shapes: BTreeMap::new(),
    }
}
