//! An export and an import in the smallest form.
