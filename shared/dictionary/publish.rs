//! The functions by which the program writes objects: those whose entries have an expression, the
//! key `value`.

use super::model::{Dictionary, Entry, Object, ObjectCode};
use std::fmt::Write;

impl Dictionary {
    /// Returns the code of a function `publish_NAME` for each row of the table `publish`. The
    /// function writes the entries whose expression uses this row.
    pub fn publish_functions(&self) -> String {
        let mut code = String::new();
        for (name, kind) in &self.publish {
            let mut setters = String::new();
            for object in &self.objects {
                for entry in &object.entries {
                    if let Some(value) = &entry.value
                        && takes_from(value, name)
                    {
                        let place = entry.place_name(object);
                        let _ = writeln!(setters, "values.set({place}, {value});");
                    }
                }
            }
            let _ = writeln!(
                code,
                "pub fn publish_{name}<const N: usize>(values: &mut Values<N>, {name}: &{kind}) \
                 {{\n{setters}}}"
            );
        }
        code
    }

    /// Number of rows of the table `publish` that an expression uses.
    pub fn sources_of(&self, value: &str) -> usize {
        let used = |name: &&String| takes_from(value, name);
        self.publish.keys().filter(used).count()
    }
}

impl Entry {
    /// Name of the constant with the place of this entry.
    pub fn place_name(&self, object: &Object) -> String {
        let index = object.index;
        if object.code == ObjectCode::Var || object.is_uniform() {
            format!("OBJECT{index:X}")
        } else {
            format!("OBJECT{index:X}_{}", self.field.to_uppercase())
        }
    }
}

/// Returns true if the expression `value` contains a field or method of the variable `source`.
fn takes_from(value: &str, source: &str) -> bool {
    let in_name = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '.';
    let mut places = value.match_indices(source);
    places.any(|(at, _)| {
        !value[..at].ends_with(in_name) && value[at + source.len()..].starts_with('.')
    })
}
