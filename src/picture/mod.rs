//! Pictures on disk: EXR and PNG, written atomically, and tone mapping.
