//! File formats recognised by their first bytes.

/// Returns the bytes without the UTF-8 byte order mark that some editors put in front.
pub fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Names the format that the first bytes look like, in words.
///
/// # Example
///
/// ```
/// use trunnion_geometry::import::looks_like;
///
/// assert_eq!(looks_like(b"ISO-10303-21;"), "STEP");
/// assert_eq!(looks_like(b"PK\x03\x04"), "a ZIP archive (3MF, FreeCAD and others)");
/// ```
pub fn looks_like(bytes: &[u8]) -> &'static str {
    /// First bytes of each format, and its name.
    const BEGINNINGS: [(&[u8], &str); 14] = [
        (b"ISO-10303-21", "STEP"),
        (b"solid", "STL (text)"),
        (b"{", "JSON"),
        (b"[", "JSON"),
        (b"PK\x03\x04", "a ZIP archive (3MF, FreeCAD and others)"),
        (b"<?xml", "XML"),
        (b"<", "XML or HTML"),
        (b"%PDF", "PDF"),
        (b"CASCADE Topology", "an OCCT BREP file"),
        (b"DBRep_DrawableShape", "an OCCT BREP file"),
        (b"**ABCDEF", "Parasolid"),
        (b"%", "an NC program"),
        (b"PARTNO", "an APT/CL file"),
        (b"\x1f\x8b", "a gzip archive"),
    ];
    let start = bytes.trim_ascii_start();
    if start.is_empty() {
        return "an empty file";
    }
    // A binary STL may begin with anything, `solid` included: its length follows from the count.
    let triangles = bytes.get(80..84).and_then(|count| <[u8; 4]>::try_from(count).ok());
    let length = triangles.map(|count| 84 + 50 * u64::from(u32::from_le_bytes(count)));
    if length == Some(bytes.len() as u64) {
        return "STL (binary)";
    }
    if let Some((_, name)) = BEGINNINGS.iter().find(|(begin, _)| start.starts_with(begin)) {
        return name;
    }
    // IGES: fixed records of 80 columns with the letter of their section in column 73.
    if bytes.get(72).is_some_and(|byte| *byte == b'S') && bytes.get(73..80).is_some_and(digits) {
        return "IGES";
    }
    let head = bytes.get(..512.min(bytes.len())).unwrap_or_default();
    if head.contains(&0) { "binary data" } else { "some other text" }
}

fn digits(column: &[u8]) -> bool {
    column.iter().all(|byte| byte.is_ascii_digit() || *byte == b' ')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_told_apart() {
        assert_eq!(looks_like(b" \n"), "an empty file");
        assert_eq!(looks_like(b"solid part\nfacet"), "STL (text)");
        assert_eq!(looks_like(b"\n{ \"degree\": 1 }"), "JSON");
        let mut stl = b"solid in name only".to_vec();
        stl.resize(80, 0);
        stl.extend(1_u32.to_le_bytes());
        stl.resize(134, 0);
        assert_eq!(looks_like(&stl), "STL (binary)");
        let iges = format!("{:72}S      1\n", "part");
        assert_eq!(looks_like(iges.as_bytes()), "IGES");
        assert_eq!(looks_like(b"\x00\x01"), "binary data");
    }
}
