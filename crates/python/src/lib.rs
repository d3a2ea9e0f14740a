//! Schemas in Python: the extension module `jde._jde`, on which the package `jde` in `python/` builds.
//!
//! Built for Python's stable ABI from 3.10 on, so that one file serves all later versions.

use pyo3::prelude::*;

/// What the package needs of Rust.
#[pymodule]
mod _jde {
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
