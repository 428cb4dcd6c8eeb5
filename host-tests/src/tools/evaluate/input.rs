//! Reads values from a JSON document, with their paths for errors, and converts results to JSON.

use super::EvaluateError;
use serde_json::Value;
use std::fmt::Debug;
use tautrack::math::Scalar;

/// A value of the document with its path, which errors name.
pub struct Input<'a> {
    value: &'a Value,
    path: String,
}

impl<'a> Input<'a> {
    pub fn root(value: &'a Value) -> Self {
        Self {
            value,
            path: String::new(),
        }
    }

    /// The error for a value with the wrong type or length.
    pub fn unexpected<T>(&self, expected: impl Into<String>) -> Result<T, EvaluateError> {
        let path = if self.path.is_empty() {
            "the document".to_owned()
        } else {
            self.path.clone()
        };
        Err(EvaluateError::Unexpected {
            path,
            expected: expected.into(),
        })
    }

    /// The error for values that a library function does not accept.
    pub fn refused(&self, reason: impl Debug) -> EvaluateError {
        EvaluateError::Refused {
            path: self.path.clone(),
            reason: format!("{reason:?}"),
        }
    }

    pub fn member(&self, name: &str) -> Result<Input<'a>, EvaluateError> {
        let dot = if self.path.is_empty() { "" } else { "." };
        let path = format!("{}{dot}{name}", self.path);
        match self.value {
            Value::Object(members) => match members.get(name) {
                Some(value) => Ok(Input { value, path }),
                None => Err(EvaluateError::Missing { path }),
            },
            _ => self.unexpected("an object"),
        }
    }

    pub fn members(&self) -> Result<Vec<(&'a str, Input<'a>)>, EvaluateError> {
        let Value::Object(members) = self.value else {
            return self.unexpected("an object");
        };
        Ok(members
            .iter()
            .map(|(name, value)| {
                let path = format!("{}.{name}", self.path);
                (name.as_str(), Input { value, path })
            })
            .collect())
    }

    pub fn elements(&self) -> Result<Vec<Input<'a>>, EvaluateError> {
        let Value::Array(elements) = self.value else {
            return self.unexpected("an array");
        };
        Ok(elements
            .iter()
            .enumerate()
            .map(|(index, value)| {
                let path = format!("{}[{index}]", self.path);
                Input { value, path }
            })
            .collect())
    }

    pub fn text(&self, name: &str) -> Result<&'a str, EvaluateError> {
        let member = self.member(name)?;
        match member.value {
            Value::String(text) => Ok(text),
            _ => member.unexpected("a string"),
        }
    }

    /// Reads a boolean.
    pub fn truth(&self, name: &str) -> Result<bool, EvaluateError> {
        let member = self.member(name)?;
        match member.value {
            Value::Bool(truth) => Ok(*truth),
            _ => member.unexpected("true or false"),
        }
    }

    fn as_number(&self) -> Result<f64, EvaluateError> {
        match self.value.as_f64() {
            Some(number) => Ok(number),
            None => self.unexpected("a number"),
        }
    }

    /// Reads exactly `N` numbers.
    pub fn as_numbers<const N: usize>(&self) -> Result<[f64; N], EvaluateError> {
        let mut numbers = [0.0; N];
        for (number, element) in numbers.iter_mut().zip(&self.array::<N>()?) {
            *number = element.as_number()?;
        }
        Ok(numbers)
    }

    /// Reads a number in double precision.
    pub fn number(&self, name: &str) -> Result<f64, EvaluateError> {
        self.member(name)?.as_number()
    }

    /// Reads a boolean.
    pub fn flag(&self, name: &str) -> Result<bool, EvaluateError> {
        let member = self.member(name)?;
        match member.value.as_bool() {
            Some(flag) => Ok(flag),
            None => member.unexpected("true or false"),
        }
    }

    /// Reads exactly `N` numbers in double precision.
    pub fn numbers<const N: usize>(&self, name: &str) -> Result<[f64; N], EvaluateError> {
        self.member(name)?.as_numbers()
    }

    /// Reads any number of rows of `N` numbers.
    pub fn rows<const N: usize>(&self, name: &str) -> Result<Vec<[f64; N]>, EvaluateError> {
        let rows = self.member(name)?.elements()?;
        rows.iter().map(Self::as_numbers).collect()
    }

    /// Reads any number of numbers.
    pub fn list(&self, name: &str) -> Result<Vec<f64>, EvaluateError> {
        let elements = self.member(name)?.elements()?;
        elements.iter().map(Self::as_number).collect()
    }

    /// Reads an array of exactly `N` elements.
    pub fn array<const N: usize>(&self) -> Result<[Input<'a>; N], EvaluateError> {
        let elements = self.elements()?;
        let count = elements.len();
        elements
            .try_into()
            .or_else(|_| self.unexpected(format!("an array of {N}, not of {count}")))
    }

    /// Reads a matrix: three rows of three numbers.
    pub fn matrix(&self) -> Result<[[f64; 3]; 3], EvaluateError> {
        let [x, y, z] = self.array()?;
        Ok([x.as_numbers()?, y.as_numbers()?, z.as_numbers()?])
    }

    /// Reads exactly `N` numbers in the precision of the computation.
    pub fn scalars<S: Scalar, const N: usize>(&self, name: &str) -> Result<[S; N], EvaluateError> {
        Ok(self.numbers(name)?.map(S::from_f64))
    }
}

/// Converts a number to JSON; NaN and infinity become `null`.
pub fn number<S: Scalar>(value: S) -> Value {
    value.to_f64().into()
}

/// Converts numbers to a JSON array.
pub fn numbers<S: Scalar>(values: &[S]) -> Value {
    values.iter().map(|value| number(*value)).collect()
}

/// Converts a matrix to JSON, row by row.
pub fn matrix<S: Scalar, const N: usize>(rows: &[[S; N]]) -> Value {
    rows.iter().map(|row| numbers(row)).collect()
}
