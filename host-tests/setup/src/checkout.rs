//! Finds the checkout that a program works on. It is found at run time, so that a copied checkout
//! uses its own files.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::{env, fmt, io};

/// Files and folders that only the root folder of a checkout contains.
const SIGNS: [&str; 3] = ["Cargo.toml", "shared/dictionary", "host-tests/scenarios"];

/// Error: none of the folders, nor any above them, is a checkout.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct NoCheckout(pub Vec<PathBuf>);

impl fmt::Display for NoCheckout {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "there is no tautrack checkout at or above ")?;
        for (index, folder) in self.0.iter().enumerate() {
            let separator = if index == 0 { "" } else { ", nor " };
            write!(f, "{separator}{}", folder.display())?;
        }
        write!(f, "; change to a folder of the checkout")
    }
}

impl std::error::Error for NoCheckout {}

impl From<NoCheckout> for io::Error {
    fn from(error: NoCheckout) -> Self {
        Self::new(io::ErrorKind::NotFound, error)
    }
}

/// Returns the root folder of the checkout, which contains rust-toolchain.toml. Searches upward
/// from the package that cargo runs, then from the working directory, then from this program's
/// file. The first call determines the result for the whole process.
///
/// # Errors
/// [`NoCheckout`], with the folders searched.
pub fn root() -> Result<&'static Path, NoCheckout> {
    static ROOT: OnceLock<Result<PathBuf, NoCheckout>> = OnceLock::new();
    let package = || env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let program = || Some(env::current_exe().ok()?.parent()?.to_owned());
    let places = || [package(), env::current_dir().ok(), program()];
    let found = ROOT.get_or_init(|| find(places().into_iter().flatten()));
    found.as_deref().map_err(Clone::clone)
}

/// Returns the first checkout at or above one of `places`, in their order.
///
/// # Errors
/// [`NoCheckout`], with the places.
pub fn find(places: impl IntoIterator<Item = PathBuf>) -> Result<PathBuf, NoCheckout> {
    let is_root = |folder: &&Path| SIGNS.iter().all(|sign| folder.join(sign).exists());
    let mut seen = Vec::new();
    for place in places {
        if let Some(root) = place.ancestors().find(is_root) {
            return Ok(root.to_owned());
        }
        seen.push(place);
    }
    Err(NoCheckout(seen))
}
