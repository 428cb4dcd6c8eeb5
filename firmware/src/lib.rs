//! The nodes of tautrack.
