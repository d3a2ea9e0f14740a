//! What must hold for any bytes. The fuzz targets run the same functions.

use jde_panel::{Gesture, List, check, decode, encode};

/// A list that passes its check is unchanged by encoding and decoding.
pub(crate) fn list(data: &[u8]) {
    if let Ok(list) = decode::<List>(data)
        && check(&list).is_ok()
    {
        assert_eq!(decode(&encode(&list)), Ok(list));
    }
}

/// A gesture that passes its check is unchanged by encoding and decoding, and has a description.
pub(crate) fn gesture(data: &[u8]) {
    if let Ok(gesture) = decode::<Gesture>(data)
        && gesture.check().is_ok()
    {
        assert!(!gesture.words("example").is_empty());
        assert_eq!(decode(&encode(&gesture)), Ok(gesture));
    }
}
