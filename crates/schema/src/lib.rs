//! What an author of schemas imports.
