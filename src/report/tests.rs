use super::*;

#[test]
fn look() {
    let dir = std::path::Path::new("/tmp/bq_copy");
    let text = std::fs::read_to_string(dir.join("results.json")).unwrap();
    let results: Results = serde_json::from_str(&text).unwrap();
    write(&results, dir).unwrap();
}
