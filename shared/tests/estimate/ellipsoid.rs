//! The WGS 84 ellipsoid in double precision.

/// Latitude and longitude, degrees, and height above the ellipsoid, m, of a place in Angers.
pub const ANGERS: [f64; 3] = [47.478_4, -0.563_2, 88.0];

const EQUATOR: f64 = 6_378_137.0;
const FLATTENING: f64 = 1.0 / 298.257_223_563;

/// Earth-centred axes: x to latitude and longitude 0, z to the north pole.
fn earth_centred([latitude, longitude, height]: [f64; 3]) -> [f64; 3] {
    let pole = EQUATOR * (1.0 - FLATTENING);
    let (sine, cosine) = latitude.to_radians().sin_cos();
    let root = (EQUATOR * cosine).hypot(pole * sine);
    let across = (EQUATOR * EQUATOR / root + height) * cosine;
    let (east, there) = longitude.to_radians().sin_cos();
    [
        across * there,
        across * east,
        (pole * pole / root + height) * sine,
    ]
}

/// Latitude and longitude, degrees, and height, m, of a place at this distance (north, west, up; m)
/// from a site, by Newton's method on [`earth_centred`].
pub fn geodetic(site: [f64; 3], [north, west, up]: [f64; 3]) -> [f64; 3] {
    let (sine, cosine) = site[0].to_radians().sin_cos();
    let (east_y, east_x) = site[1].to_radians().sin_cos();
    let outward = up * cosine - north * sine;
    let [x, y, z] = earth_centred(site);
    let x = x + outward * east_x + west * east_y;
    let y = y + outward * east_y - west * east_x;
    let z = z + north * cosine + up * sine;
    let longitude = y.atan2(x).to_degrees();
    let mut found = [site[0], longitude, site[2]];
    for _ in 0..4 {
        let [there_x, there_y, there_z] = earth_centred(found);
        let (out, along) = (x.hypot(y) - there_x.hypot(there_y), z - there_z);
        let (sine, cosine) = found[0].to_radians().sin_cos();
        found[0] += ((along * cosine - out * sine) / EQUATOR).to_degrees();
        found[2] += out * cosine + along * sine;
    }
    found
}
