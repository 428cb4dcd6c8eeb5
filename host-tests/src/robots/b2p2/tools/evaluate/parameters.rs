//! Reads the `params` of the groups about B2P2.

use crate::tools::evaluate::EvaluateError;
use crate::tools::evaluate::input::Input;
use tautrack::math::Scalar;
use tautrack::robots::b2p2::parameters::Lengths;
use tautrack::robots::b2p2::{Parameters, Tabulated};

/// Reads `g`, `l1`, `l2`, `c3` (distance of axle 3 from R8), and `mass`, `com` and `inertia_origin`
/// of the three segments.
pub fn parameters<S: Scalar>(params: &Input) -> Result<Parameters<S>, EvaluateError> {
    let lengths = Lengths {
        l1: params.number("l1")?,
        l2: params.number("l2")?,
        axle_3: params.number("c3")?,
        gravity: params.number("g")?,
    };
    let masses: [f64; 3] = params.numbers("mass")?;
    let coms = params.member("com")?.matrix()?;
    let [first, second, third] = params.member("inertia_origin")?.array()?;
    let inertias = [first.matrix()?, second.matrix()?, third.matrix()?];
    let segments = [0, 1, 2].map(|index| Tabulated {
        mass: masses[index],
        centre_of_mass: coms[index],
        inertia_about_origin: inertias[index],
    });
    Parameters::new(&lengths, &segments).map_err(|error| params.refused(error))
}
