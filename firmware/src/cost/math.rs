//! Counts the elementary functions and the screw's geometry.

use super::counter::Table;
use super::inputs::{angle, number, settings};
use core::hint::black_box;
use tautrack::math;
use tautrack::screw::Geometry;
use tautrack::settings::Setting;

pub fn count(table: &mut Table) {
    let none = &mut ();
    table.kernel(
        "sin_cos_q30",
        none,
        |(), call, _| angle(call),
        |(), theta| math::sin_cos_q30(theta),
    );
    table.kernel(
        "sin_cos",
        none,
        |(), call, _| angle(call),
        |(), theta| math::sin_cos(theta),
    );
    table.kernel(
        "sqrt",
        none,
        |(), call, random| number(call, random),
        |(), value| math::sqrt(value),
    );
    table.kernel(
        "atan2",
        none,
        |(), call, random| (number(call, random), number(call / 7, random)),
        |(), (y, x)| math::atan2(y, x),
    );
    table.kernel(
        "limit",
        none,
        |(), call, random| (number(call, random), number(call / 7, random)),
        |(), (value, bound)| math::limit(value, bound),
    );

    let settings = settings();
    let [l1, l2, k] = [Setting::LengthL1, Setting::LengthL2, Setting::LengthK]
        .map(|setting| settings.get(setting));
    let Ok(geometry) = Geometry::from_micrometres(l1, l2, k) else {
        return; // the nominal geometry is valid; otherwise the host finds no entries
    };
    let mut geometry = black_box(geometry);
    table.kernel(
        "screw length",
        &mut geometry,
        |_, call, _| angle(call),
        |geometry, theta| geometry.length(theta).to_bits(),
    );
    table.kernel(
        "screw extension with derivative",
        &mut geometry,
        |_, call, _| angle(call),
        |geometry, theta| {
            let extension = geometry.extension(theta);
            (extension.length.to_bits(), extension.derivative.to_bits())
        },
    );
}
