//! Reads GGA and RMC sentences of NMEA 0183 byte by byte, without allocation and without floats.
//!
//! A sentence counts only if its checksum is right. Refused sentences are counted by reason. No
//! input makes this module panic.

/// Maximum number of bytes between `$` and the end of the line. The standard allows 79; receivers
/// with many decimals send more.
const LONGEST: usize = 100;

/// A place on the WGS 84 ellipsoid, in units of 1e-7 degree (11 mm of latitude).
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Place {
    /// Latitude, north positive, -9e8 to 9e8.
    pub latitude: i32,
    /// Longitude, east positive, -1.8e9 to 1.8e9.
    pub longitude: i32,
}

/// Content of a GGA sentence: fix data.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Gga {
    /// UTC time of day, ms.
    pub time_ms: Option<u32>,
    /// Place; `None` while the receiver has no fix.
    pub place: Option<Place>,
    /// Height above mean sea level, mm.
    pub altitude_mm: Option<i32>,
    /// Quality of the fix: 0 no fix, 1 GPS, 2 differential, 3 PPS, 4 and 5 carrier phase, 6
    /// extrapolated, 7 entered by hand, 8 simulated.
    pub quality: u8,
    /// Satellites in use.
    pub satellites: Option<u8>,
    /// Horizontal dilution of precision, 0.01.
    pub dilution: Option<u16>,
}

/// Content of an RMC sentence: recommended minimum data.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Rmc {
    /// UTC time of day, ms.
    pub time_ms: Option<u32>,
    /// Place; `None` while the receiver marks its data as void.
    pub place: Option<Place>,
    /// Speed over ground, mm/s.
    pub speed_mm_s: Option<u32>,
    /// Course over ground, clockwise from true north, 0.01 degree, 0 to 36000.
    pub course: Option<u16>,
}

/// Content of a valid sentence.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sentence {
    /// GGA, from any talker.
    Gga(Gga),
    /// RMC, from any talker.
    Rmc(Rmc),
}

/// Reason why a sentence is refused.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Refusal {
    /// Another sentence began before its end.
    CutShort,
    /// It has more bytes than the longest sentence.
    TooLong,
    /// It has this byte, which is no printable character.
    NotText(u8),
    /// It does not end in `*` and two hexadecimal digits.
    NoChecksum,
    /// Its checksum is not that of its bytes.
    Checksum {
        /// Checksum at the end of the sentence.
        told: u8,
        /// Checksum of its bytes.
        computed: u8,
    },
    /// The field with this number is missing, or its content is invalid. The address is field 0.
    Field(u8),
}

/// Number of reasons in [`Refusal`].
pub const REASONS: usize = 6;

/// Counts of sentences since power-up; they wrap.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Counts {
    /// GGA and RMC sentences that were used.
    pub taken: u32,
    /// Valid sentences of other kinds.
    pub others: u32,
    /// Refused sentences, in the order of [`Refusal`]: cut short, too long, not text, no checksum,
    /// checksum, field.
    pub refused: [u32; REASONS],
}

impl Counts {
    /// Returns the number of sentences that were refused for any reason.
    pub fn all_refused(&self) -> u32 {
        self.refused
            .iter()
            .fold(0, |sum, count| sum.wrapping_add(*count))
    }
}

/// Finds sentences in the bytes of a serial line.
#[derive(Clone, Debug)]
pub struct Reader {
    text: [u8; LONGEST],
    length: usize,
    inside: bool,
    counts: Counts,
}

impl Default for Reader {
    fn default() -> Self {
        Self {
            text: [0; LONGEST],
            length: 0,
            inside: false,
            counts: Counts::default(),
        }
    }
}

impl Reader {
    /// Takes the next byte. If it is the last one of a sentence, returns the sentence or why it is
    /// refused.
    ///
    /// All bytes are allowed. Bytes between sentences are ignored, and so are valid sentences of
    /// other kinds.
    pub fn push(&mut self, byte: u8) -> Option<Result<Sentence, Refusal>> {
        let found = match byte {
            b'$' => {
                let cut_short = core::mem::replace(&mut self.inside, true);
                self.length = 0;
                if !cut_short {
                    return None;
                }
                Err(Refusal::CutShort)
            }
            _ if !self.inside => return None,
            b'\r' | b'\n' => {
                self.inside = false;
                parse(self.text.get(..self.length)?)
            }
            b' '..=b'~' => {
                if let Some(place) = self.text.get_mut(self.length) {
                    *place = byte;
                    self.length += 1;
                    return None;
                }
                self.inside = false;
                Err(Refusal::TooLong)
            }
            _ => {
                self.inside = false;
                Err(Refusal::NotText(byte))
            }
        };
        let count = match found {
            Ok(Some(_)) => &mut self.counts.taken,
            Ok(None) => &mut self.counts.others,
            Err(Refusal::CutShort) => &mut self.counts.refused[0],
            Err(Refusal::TooLong) => &mut self.counts.refused[1],
            Err(Refusal::NotText(_)) => &mut self.counts.refused[2],
            Err(Refusal::NoChecksum) => &mut self.counts.refused[3],
            Err(Refusal::Checksum { .. }) => &mut self.counts.refused[4],
            Err(Refusal::Field(_)) => &mut self.counts.refused[5],
        };
        *count = count.wrapping_add(1);
        found.transpose()
    }

    /// Returns the counts of sentences so far.
    pub fn counts(&self) -> &Counts {
        &self.counts
    }
}

/// Parses `text`, which is what stands between `$` and the end of the line. `None` for a valid
/// sentence of another kind.
#[inline(never)]
fn parse(text: &[u8]) -> Result<Option<Sentence>, Refusal> {
    let star = text.iter().rposition(|byte| *byte == b'*');
    let parts = star.and_then(|star| text.split_at_checked(star));
    let Some((body, &[_, high, low])) = parts else {
        return Err(Refusal::NoChecksum);
    };
    let digits = hexadecimal(high).zip(hexadecimal(low));
    let told = digits.map(|(high, low)| high << 4 | low);
    let told = told.ok_or(Refusal::NoChecksum)?;
    let computed = body.iter().fold(0, |sum, byte| sum ^ byte);
    if told != computed {
        return Err(Refusal::Checksum { told, computed });
    }
    let fields = Fields(body);
    let &[first, second, ref kind @ ..] = fields.text(0)? else {
        return Err(Refusal::Field(0));
    };
    let talker = |byte: u8| byte.is_ascii_uppercase() || byte.is_ascii_digit();
    if !talker(first) || !talker(second) {
        return Err(Refusal::Field(0));
    }
    match kind {
        b"GGA" => gga(&fields).map(|gga| Some(Sentence::Gga(gga))),
        b"RMC" => rmc(&fields).map(|rmc| Some(Sentence::Rmc(rmc))),
        _ => Ok(None),
    }
}

#[inline(never)]
fn gga(fields: &Fields) -> Result<Gga, Refusal> {
    let quality = fields.required(6, |text| match text {
        [digit @ b'0'..=b'8'] => Some(digit - b'0'),
        _ => None,
    })?;
    let altitude_mm = fields.optional(9, |text| decimal(text, 3))?;
    if altitude_mm.is_some() && fields.text(10)? != b"M" {
        return Err(Refusal::Field(10));
    }
    Ok(Gga {
        time_ms: fields.optional(1, time)?,
        place: if quality == 0 {
            None
        } else {
            Some(fields.place(2)?)
        },
        altitude_mm,
        quality,
        satellites: fields.optional(7, |text| decimal(text, 0)?.try_into().ok())?,
        dilution: fields.optional(8, |text| decimal(text, 2)?.try_into().ok())?,
    })
}

#[inline(never)]
fn rmc(fields: &Fields) -> Result<Rmc, Refusal> {
    let valid = fields.required(2, |text| match text {
        b"A" => Some(true),
        b"V" => Some(false),
        _ => None,
    })?;
    Ok(Rmc {
        time_ms: fields.optional(1, time)?,
        place: if valid { Some(fields.place(3)?) } else { None },
        speed_mm_s: fields.optional(7, |text| {
            // A knot is 1852 m/h.
            let knots_e3 = u32::try_from(decimal(text, 3)?).ok()?;
            Some(knots_e3.checked_mul(463)? / 900)
        })?,
        course: fields.optional(8, |text| {
            let course = u16::try_from(decimal(text, 2)?).ok()?;
            (course <= 36_000).then_some(course)
        })?,
    })
}

/// The fields of a sentence, which commas separate. Field 0 is the address.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    #[inline(never)]
    fn text(&self, number: u8) -> Result<&'a [u8], Refusal> {
        let mut fields = self.0.split(|byte| *byte == b',');
        fields
            .nth(usize::from(number))
            .ok_or(Refusal::Field(number))
    }

    fn required<T>(&self, number: u8, read: impl FnOnce(&[u8]) -> Option<T>) -> Result<T, Refusal> {
        read(self.text(number)?).ok_or(Refusal::Field(number))
    }

    fn optional<T>(
        &self,
        number: u8,
        read: impl FnOnce(&[u8]) -> Option<T>,
    ) -> Result<Option<T>, Refusal> {
        if self.text(number)?.is_empty() {
            return Ok(None);
        }
        self.required(number, read).map(Some)
    }

    /// Reads latitude, its hemisphere, longitude and its hemisphere from field `first` on.
    #[inline(never)]
    fn place(&self, first: u8) -> Result<Place, Refusal> {
        let side = |number, positive: u8, negative: u8| {
            self.required(number, |text| match text {
                [letter] if *letter == positive => Some(1),
                [letter] if *letter == negative => Some(-1),
                _ => None,
            })
        };
        let latitude = self.required(first, |text| degrees(text, 2, 90))?;
        let longitude = self.required(first + 2, |text| degrees(text, 3, 180))?;
        Ok(Place {
            latitude: latitude * side(first + 1, b'N', b'S')?,
            longitude: longitude * side(first + 3, b'E', b'W')?,
        })
    }
}

/// Returns the value of a hexadecimal digit.
#[inline(never)]
fn hexadecimal(digit: u8) -> Option<u8> {
    (digit as char).to_digit(16).map(|value| value as u8)
}

/// Reads digits with an optional sign and fraction, in units of 10^-`places`. Further decimals are
/// rounded.
#[inline(never)]
fn decimal(text: &[u8], places: u32) -> Option<i32> {
    let (negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        _ => (false, text),
    };
    let mut parts = digits.split(|byte| *byte == b'.');
    let (whole, fraction) = (parts.next()?, parts.next().unwrap_or(b""));
    if parts.next().is_some() || whole.len() + fraction.len() == 0 {
        return None;
    }
    let mut value = 0_i64;
    for digit in whole {
        // Bounded, so that the decimals after it cannot overflow.
        value = (value * 10 + digit_value(*digit)?).min(1 << 40);
    }
    for place in 0..places as usize {
        let digit = fraction.get(place).map_or(Some(0), |d| digit_value(*d))?;
        value = (value * 10 + digit).min(1 << 40);
    }
    let rest = fraction.get(places as usize..).unwrap_or(b"");
    for (place, digit) in rest.iter().enumerate() {
        let digit = digit_value(*digit)?;
        value += i64::from(place == 0 && digit >= 5);
    }
    i32::try_from(if negative { -value } else { value }).ok()
}

#[inline(never)]
fn digit_value(digit: u8) -> Option<i64> {
    digit.is_ascii_digit().then(|| i64::from(digit - b'0'))
}

/// Reads an angle as 1e-7 degree, rounded: degrees in `wide` digits, minutes in two digits, and the
/// fraction of the minutes.
#[inline(never)]
fn degrees(text: &[u8], wide: usize, most: i32) -> Option<i32> {
    let (degrees, minutes) = text.split_at_checked(wide)?;
    let &[b'0'..=b'5', b'0'..=b'9', ref fraction @ ..] = minutes else {
        return None;
    };
    if !matches!(fraction, [] | [b'.', ..]) || degrees.first() == Some(&b'-') {
        return None;
    }
    let value = decimal(degrees, 0)? * 10_000_000 + (decimal(minutes, 7)? + 30) / 60;
    (value <= most * 10_000_000).then_some(value)
}

/// Reads `hhmmss` with an optional fraction, as ms of the day.
#[inline(never)]
fn time(text: &[u8]) -> Option<u32> {
    let (hours, rest) = text.split_at_checked(2)?;
    let (minutes, seconds) = rest.split_at_checked(2)?;
    let two = |text: &[u8]| match text {
        [b'0'..=b'9', b'0'..=b'9'] => u32::try_from(decimal(text, 0)?).ok(),
        _ => None,
    };
    let &[b'0'..=b'9', b'0'..=b'9', ref fraction @ ..] = seconds else {
        return None;
    };
    if !matches!(fraction, [] | [b'.', ..]) {
        return None;
    }
    let (hours, minutes) = (two(hours)?, two(minutes)?);
    let milliseconds = u32::try_from(decimal(seconds, 3)?).ok()?;
    // A leap second is second 60.
    (hours < 24 && minutes < 60 && milliseconds < 61_000)
        .then(|| (hours * 60 + minutes) * 60_000 + milliseconds)
}
