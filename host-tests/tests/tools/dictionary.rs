//! Tests that the loader of the object dictionaries refuses a bad file, and that its error names
//! the file, the object and the key.

use std::fs;
use std::path::PathBuf;
use tautrack_host_tests::programs::setup::checkout;
use tautrack_host_tests::tools::generate::dictionary::{ROLES, load};

/// Folder with a copy of the dictionaries, which is removed at the end.
struct Copy(PathBuf);

impl Copy {
    fn new(name: &str) -> Self {
        let folder = format!("tautrack-dictionary-{}-{name}", std::process::id());
        let copy = Self(std::env::temp_dir().join(folder));
        fs::create_dir_all(&copy.0).unwrap();
        copy.restore();
        copy
    }

    fn restore(&self) {
        let dictionaries = checkout::root().unwrap().join("shared/dictionary");
        for file in ["axle", "screw", "guard", "drive", "common"] {
            let file = format!("{file}.toml");
            fs::copy(dictionaries.join(&file), self.0.join(file)).unwrap();
        }
    }

    /// Replaces a line in the file `name`: from the first line that ends with `after` on, the
    /// first that begins with `old`.
    fn change(&self, name: &str, after: &str, old: &str, new: &str) {
        let path = self.0.join(name).with_extension("toml");
        let text = fs::read_to_string(&path).unwrap();
        let mut lines: Vec<&str> = text.lines().collect();
        let start = lines.iter().position(|line| line.ends_with(after));
        let start = start.expect(after);
        let at = lines[start..].iter().position(|line| line.starts_with(old));
        lines[start + at.expect(old)] = new;
        fs::write(path, lines.join("\n")).unwrap();
    }

    fn errors(&self) -> Vec<String> {
        let results = ROLES.map(|role| load(&self.0, role));
        results.into_iter().filter_map(Result::err).collect()
    }
}

impl Drop for Copy {
    fn drop(&mut self) {
        // A folder that stays among the temporary ones harms nobody.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Asserts that each change is refused by an error of one line. A row of the table has the
/// parameters of [`Copy::change`] (`\` ends a line), and the begin of the error after the file.
fn assert_refused(name: &str, table: &str) {
    let copy = Copy::new(name);
    assert_eq!(copy.errors(), [""; 0], "without a change");
    for row in table.trim().lines() {
        let [file, after, old, new, error] = row.split('|').collect::<Vec<_>>()[..] else {
            panic!("not five columns: {row}");
        };
        let [file, after, old, new] = [file, after, old, new].map(str::trim);
        copy.restore();
        copy.change(file, after, old, &new.replace('\\', "\n"));
        let errors = copy.errors();
        assert!(!errors.is_empty(), "accepted: {row}");
        for got in errors {
            let expected = format!("{file}.toml: {}", error.trim());
            assert!(got.starts_with(&expected), "{row}\ngives: {got}");
            assert!(!got.contains('\n'), "{got}");
        }
    }
}

#[test]
fn a_bad_key_of_an_object_is_refused_with_file_object_and_key() {
    assert_refused(
        "key",
        r#"
drive | 0x6040 | data || object 0x6040: `data_type` is missing
drive | 0x6040 | access || object 0x6040: `access_type` is missing
drive | 0x6040 | pdo_mapping || object 0x6040: `pdo_mapping` is missing
drive | 0x6040 | object_type || object 0x6040: `object_type` is missing
drive | 0x6040 | parameter || object 0x6040: `parameter_name` is missing
drive | 0x6040 | index || an object: `index` is missing
drive | 0x6040 | index | index = 0x16040 | an object: `index` is wrong: invalid value
drive | 0x6040 | data | data_type = "uint12" | object 0x6040: `data_type` is wrong: `uint12`
drive | 0x6040 | access | access_type = "wr" | object 0x6040: `access_type` is wrong: unknown
drive | 0x6040 | pdo_mapping | pdo_mapping = 1 | object 0x6040: `pdo_mapping` is wrong:
drive | 0x6040 | object_type | object_type = "record" | object 0x6040: `access_type` is no known key
drive | 0x6040 | default | default_value = 0\a = 1 | object 0x6040: `a` is no known key
drive | 0x6040 | default | default_value = 65536 | object 0x6040: `default_value` is 65536, not
drive | 0x6040 | default | default_value = -1 | object 0x6040: `default_value` is -1, not uint16
drive | 0x6040 | default | default_value = "0" | object 0x6040: `default_value` is "0", not uint16
drive | 0x2063 | default | default_value = 0 | object 0x2063: `default_value` is 0, not octet
drive | 0x2063 | default || object 0x2063: `default_value` is missing
drive | 0x605a | limits | limits = [1, 5] | object 0x605a: `limits` [1, 5] are not around the
drive | 0x605a | limits | limits = [0, 32768] | object 0x605a: `limits` [0, 32768] are not around
drive | 0x605a | limits | limits = [6] | object 0x605a: `limits` is wrong: invalid length 1
drive | 0x607d | data | data_type = "int16" | object 0x607d: the elements of an array have one
common | sub_index = 4 | data | data_type = "int" | object 0x2020:4: `data_type` is wrong: `int`
common | sub_index = 4 | field_name || object 0x2020:4: `field_name` is missing
common | sub_index = 4 | sub_index || object 0x2020: an element: `sub_index` is missing
common | sub_index = 4 | default | a = 1 | object 0x2020:4: `a` is no known key
guard | 0x2100 | array_size || object 0x2100: `access_type` is no known key
guard | 0x2100 | array_size | array_size = 0 | object 0x2100: `array_size` is wrong: invalid value
"#,
    );
}

#[test]
fn what_is_defined_twice_is_refused() {
    // 1018 is an object that every node has, and 0x2100 is in another file.
    assert_refused(
        "twice",
        r#"
drive | 0x6040 | index | index = 0x6041 | object 0x6041: `index` is used twice
drive | 0x6040 | index | index = 0x1018 | object 0x1018: `index` is used twice
common | 0x2020 | index | index = 0x2100 | object 0x2100: `index` is used twice
common | sub_index = 4 | sub_index | sub_index = 3 | object 0x2020:3: `sub_index` is used twice
common | sub_index = 4 | sub_index | sub_index = 0 | object 0x2020:0: `sub_index` is used twice
drive | [rpdo.2] | [rpdo.2] | [rpdo.3] | `rpdo.3` is in another file, too
common | | # Objects | [publish]\outputs = "X" | `publish.outputs` is in another file, too
"#,
    );
}

#[test]
fn a_value_takes_from_one_row_of_publish_and_belongs_to_no_array() {
    assert_refused(
        "value",
        r#"
drive | 0x6041 | value | value = "a.outputs.b" | object 0x6041:0: `value` takes from 0
drive | 0x6041 | value | value = "an_outputs.b" | object 0x6041:0: `value` takes from 0
drive | 0x6041 | value | value = "a.b" | object 0x6041:0: `value` takes from 0
drive | 0x6041 | value | value = "outputs.a(snapshot.b)" | object 0x6041:0: `value` takes from 2
guard | 0x2100 | pdo | pdo_mapping = "none"\value = "trip.a" | object 0x2100: an array takes no
"#,
    );
}

#[test]
fn a_bad_key_outside_of_the_objects_is_refused_with_file_and_key() {
    assert_refused(
        "other",
        r#"
axle | [device] | product || `device` is wrong: missing field `product_code`
axle | [device] | product | product_code = -1 | `device` is wrong: invalid value: integer `-1`
axle | [device] | product | product_code = 1\a = 1 | `device` is wrong: unknown field `a`
axle | [device] | [device] | [devices] | `device` is missing
axle || include | include = ["drive", "common"]\a = 1 | `a` is no known key
common | | # Objects | include = [] | `include` is no known key
drive | [rpdo.1] | cob_id || `rpdo.1` is wrong: missing field `cob_id`
drive | [rpdo.1] | cob_id | cob_id = "0x300" | `rpdo.1` is wrong: invalid type: string
drive | [rpdo.2] | mappings | mappings = [{ index = 1 }] | `rpdo.2` is wrong: missing field `sub`
drive | [rpdo.2] | [rpdo.2] | [rpdo.4] | `rpdo.4` must be below 4
drive | [rpdo.2] | [rpdo.2] | [rpdo.x] | `rpdo.x` must be below 4
"#,
    );
}

#[test]
fn a_file_that_is_missing_or_no_toml_is_named() {
    let copy = Copy::new("missing");
    for (new, file) in [("include = [\"motor\"]", "motor"), ("include = [", "axle")] {
        copy.restore();
        copy.change("axle", "", "include", new);
        let errors = copy.errors();
        let named = |error: &String| error.starts_with(&format!("{file}.toml: "));
        assert!(errors.len() == 1 && named(&errors[0]), "{errors:?}");
    }
}
