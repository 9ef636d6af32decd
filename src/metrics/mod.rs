//! Error metrics between pictures. Depends on no device.
