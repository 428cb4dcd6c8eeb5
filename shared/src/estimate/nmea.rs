//! Reads GGA and RMC sentences of NMEA 0183 byte by byte, without allocation and without floats.
//!
//! A sentence counts only if its checksum is right. Refused sentences are counted by reason. No
//! input makes this module panic. Each field is read when it ends, so that the work is spread over
//! the time in which the sentence arrives. GNS is not read: its place is also in GGA and RMC, which
//! have one quality and one mode for all satellite systems.

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
    /// Place; `None` while the receiver marks its data as void, estimated, entered by hand or
    /// simulated.
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
        received: u8,
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

/// Number of the mode field of RMC, the last field that is used.
const MODE: usize = 12;
/// Number of fields up to the last one that is used, with the address.
const FIELDS: usize = MODE + 1;

/// Kind of a sentence, from its address.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Gga,
    Rmc,
    Other,
    /// The address does not begin with a talker.
    Invalid,
}

/// A field of a sentence.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Field {
    Missing,
    Empty,
    Invalid,
    /// Its value in the unit of [`Gga`] or [`Rmc`].
    Value(i32),
}

/// Finds sentences in the bytes of a serial line.
#[derive(Clone, Debug)]
pub struct Reader {
    text: [u8; LONGEST],
    length: usize,
    inside: bool,
    kind: Kind,
    fields: Fields,
    /// Number and first byte of the field that is arriving. The address is field 0.
    number: usize,
    start: usize,
    /// Checksum of the bytes so far.
    sum: u8,
    /// Place of the last `*`, and the checksum of the bytes before it.
    star: Option<(usize, u8)>,
    counts: Counts,
}

impl Default for Reader {
    fn default() -> Self {
        Self {
            text: [0; LONGEST],
            length: 0,
            inside: false,
            kind: Kind::Invalid,
            fields: Fields([Field::Missing; FIELDS]),
            number: 0,
            start: 0,
            sum: 0,
            star: None,
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
    #[inline]
    pub fn push(&mut self, byte: u8) -> Option<Result<Sentence, Refusal>> {
        // Most bytes are letters, digits and points, which end neither a field nor a sentence.
        if matches!(byte, b'-'..=b'~') && (!self.inside || self.store(byte)) {
            return None;
        }
        if byte == b',' && self.inside && self.length < LONGEST {
            self.end_field();
            self.number += 1;
            self.start = self.length + 1;
            self.store(byte);
            return None;
        }
        self.push_end(byte)
    }

    /// Adds a byte to the sentence; returns whether there is room.
    #[inline]
    fn store(&mut self, byte: u8) -> bool {
        let place = self.text.get_mut(self.length);
        let room = place.is_some();
        if let Some(place) = place {
            *place = byte;
            self.sum ^= byte;
            self.length += 1;
        }
        room
    }

    /// Takes a byte that may begin or end a sentence, or that has no room.
    #[inline(never)]
    fn push_end(&mut self, byte: u8) -> Option<Result<Sentence, Refusal>> {
        let found = match byte {
            b'$' => {
                let cut_short = core::mem::replace(&mut self.inside, true);
                self.begin();
                if !cut_short {
                    return None;
                }
                Err(Refusal::CutShort)
            }
            _ if !self.inside => return None,
            b'\r' | b'\n' => {
                self.inside = false;
                self.end()
            }
            b' '..=b'~' => {
                if byte == b'*' {
                    // If another one follows, this one is part of the field, which is read again.
                    self.end_field();
                    self.star = Some((self.length, self.sum));
                }
                if self.store(byte) {
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

impl Reader {
    fn begin(&mut self) {
        (self.length, self.number, self.start) = (0, 0, 0);
        (self.sum, self.star) = (0, None);
        self.kind = Kind::Invalid;
        self.fields = Fields([Field::Missing; FIELDS]);
    }

    /// Reads the field that has arrived.
    #[inline(never)]
    fn end_field(&mut self) {
        let text = self.text.get(self.start..self.length).unwrap_or_default();
        if self.number == 0 {
            self.kind = Kind::of(text);
        } else if let Some(field) = self.fields.0.get_mut(self.number) {
            *field = self.kind.read(self.number, text);
        }
    }

    /// Returns the sentence that has ended; `None` if it is valid and of another kind.
    #[inline(never)]
    fn end(&self) -> Result<Option<Sentence>, Refusal> {
        let (star, computed) = self.star.ok_or(Refusal::NoChecksum)?;
        let Some(&[_, high, low]) = self.text.get(star..self.length) else {
            return Err(Refusal::NoChecksum);
        };
        let digits = hexadecimal(high).zip(hexadecimal(low));
        let received = digits.map(|(high, low)| high << 4 | low);
        let received = received.ok_or(Refusal::NoChecksum)?;
        if received != computed {
            return Err(Refusal::Checksum { received, computed });
        }
        match self.kind {
            Kind::Gga => self.fields.gga().map(|gga| Some(Sentence::Gga(gga))),
            Kind::Rmc => self.fields.rmc().map(|rmc| Some(Sentence::Rmc(rmc))),
            Kind::Other => Ok(None),
            Kind::Invalid => Err(Refusal::Field(0)),
        }
    }
}

impl Kind {
    fn of(address: &[u8]) -> Self {
        let talker = |byte: &u8| byte.is_ascii_uppercase() || byte.is_ascii_digit();
        match address {
            [first, second, kind @ ..] if talker(first) && talker(second) => match kind {
                b"GGA" => Self::Gga,
                b"RMC" => Self::Rmc,
                _ => Self::Other,
            },
            _ => Self::Invalid,
        }
    }

    /// Reads the text of a field.
    fn read(self, number: usize, text: &[u8]) -> Field {
        if text.is_empty() {
            return Field::Empty;
        }
        let value = match (self, number) {
            (Self::Gga | Self::Rmc, 1) => time(text),
            (Self::Gga, 2) | (Self::Rmc, 3) => degrees(text, 2, 90),
            (Self::Gga, 4) | (Self::Rmc, 5) => degrees(text, 3, 180),
            (Self::Gga, 3) | (Self::Rmc, 4) => sign(text, b'N', b'S'),
            (Self::Gga, 5) | (Self::Rmc, 6) => sign(text, b'E', b'W'),
            (Self::Gga, 6) => match text {
                [digit @ b'0'..=b'8'] => Some(i32::from(digit - b'0')),
                _ => None,
            },
            (Self::Gga, 7) => decimal(text, 0).filter(|count| (0..=0xff).contains(count)),
            (Self::Gga, 8) => decimal(text, 2).filter(|dilution| (0..=0xffff).contains(dilution)),
            (Self::Gga, 9) => decimal(text, 3),
            (Self::Gga, 10) => (text == b"M").then_some(1),
            (Self::Rmc, 2) => sign(text, b'A', b'V'),
            (Self::Rmc, 7) => decimal(text, 3).and_then(speed),
            (Self::Rmc, 8) => decimal(text, 2).filter(|course| (0..=36_000).contains(course)),
            (Self::Rmc, MODE) => mode(text),
            _ => return Field::Missing,
        };
        value.map_or(Field::Invalid, Field::Value)
    }
}

/// The fields of a sentence. Field 0, the address, is not among them.
#[derive(Clone, Copy, Debug)]
struct Fields([Field; FIELDS]);

impl Fields {
    fn gga(&self) -> Result<Gga, Refusal> {
        let quality = self.required(6)? as u8;
        let altitude_mm = self.optional(9)?;
        if altitude_mm.is_some() {
            self.required(10)?;
        }
        Ok(Gga {
            time_ms: self.optional(1)?.map(|time| time as u32),
            place: if quality == 0 {
                None
            } else {
                Some(self.place(2)?)
            },
            altitude_mm,
            quality,
            satellites: self.optional(7)?.map(|count| count as u8),
            dilution: self.optional(8)?.map(|dilution| dilution as u16),
        })
    }

    fn rmc(&self) -> Result<Rmc, Refusal> {
        let valid = self.required(2)? > 0 && self.measured()?;
        Ok(Rmc {
            time_ms: self.optional(1)?.map(|time| time as u32),
            place: if valid { Some(self.place(3)?) } else { None },
            speed_mm_s: self.optional(7)?.map(|speed| speed as u32),
            course: self.optional(8)?.map(|course| course as u16),
        })
    }

    /// Returns whether the mode is that of a measured position. Receivers older than NMEA 0183
    /// version 2.3 send none; then the status alone counts.
    fn measured(&self) -> Result<bool, Refusal> {
        match self.0[MODE] {
            Field::Invalid => Err(Refusal::Field(MODE as u8)),
            mode => Ok(mode != Field::Value(-1)),
        }
    }

    /// Latitude, its hemisphere, longitude and its hemisphere from field `first` on.
    fn place(&self, first: u8) -> Result<Place, Refusal> {
        let (latitude, longitude) = (self.required(first)?, self.required(first + 2)?);
        Ok(Place {
            latitude: latitude * self.required(first + 1)?,
            longitude: longitude * self.required(first + 3)?,
        })
    }

    fn required(&self, number: u8) -> Result<i32, Refusal> {
        match self.0.get(usize::from(number)) {
            Some(Field::Value(value)) => Ok(*value),
            _ => Err(Refusal::Field(number)),
        }
    }

    fn optional(&self, number: u8) -> Result<Option<i32>, Refusal> {
        match self.0.get(usize::from(number)) {
            Some(Field::Empty) => Ok(None),
            _ => self.required(number).map(Some),
        }
    }
}

/// Returns the value of a hexadecimal digit.
fn hexadecimal(digit: u8) -> Option<u8> {
    (digit as char).to_digit(16).map(|value| value as u8)
}

/// Returns 1 or -1.
fn sign(text: &[u8], positive: u8, negative: u8) -> Option<i32> {
    if text == [positive] {
        Some(1)
    } else {
        (text == [negative]).then_some(-1)
    }
}

/// Reads the mode indicator of NMEA 0183. Returns 1 for a measured position: autonomous,
/// differential, precise, and carrier phase (real-time kinematic, float). Returns -1 for an
/// estimated, manual or simulated position, and for none.
fn mode(text: &[u8]) -> Option<i32> {
    match text {
        b"A" | b"D" | b"P" | b"R" | b"F" => Some(1),
        b"E" | b"M" | b"S" | b"N" => Some(-1),
        _ => None,
    }
}

/// Converts 0.001 knots to mm/s. A knot is 1852 m/h.
fn speed(knots_e3: i32) -> Option<i32> {
    let scaled = u32::try_from(knots_e3).ok()?.checked_mul(463)?;
    Some((scaled / 900) as i32)
}

/// Powers of ten, by their exponent.
const POWERS: [u32; 8] = [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000];

/// Reads digits with an optional sign and fraction, in units of 10^-`places`, at most seven.
/// Further decimals are rounded.
#[inline(never)]
fn decimal(text: &[u8], places: usize) -> Option<i32> {
    let (negative, text) = match text {
        [b'-', rest @ ..] => (true, rest),
        _ => (false, text),
    };
    let (whole, fraction) = leading_digits(0, text)?;
    let decimals = match fraction {
        [] => fraction,
        [b'.', decimals @ ..] => decimals,
        _ => return None,
    };
    if text.len() == fraction.len() && decimals.is_empty() {
        return None;
    }
    let (kept, rest) = decimals.split_at_checked(places).unwrap_or((decimals, &[]));
    let (value, other) = leading_digits(whole, kept)?;
    if !other.is_empty() || !rest.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let missing = POWERS.get(places - kept.len())?;
    let rounded = u32::from(rest.first().is_some_and(|digit| *digit >= b'5'));
    let value = value.checked_mul(*missing)?.checked_add(rounded)?;
    if negative {
        0_i32.checked_sub_unsigned(value)
    } else {
        i32::try_from(value).ok()
    }
}

/// Appends the digits at the beginning of `text` to `value`; returns the rest of the text, too.
#[inline]
fn leading_digits(mut value: u32, text: &[u8]) -> Option<(u32, &[u8])> {
    let mut rest = text;
    while let [byte, tail @ ..] = rest {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        value = value.checked_mul(10)?.checked_add(u32::from(digit))?;
        rest = tail;
    }
    Some((value, rest))
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
    let degrees = decimal(degrees, 0).filter(|degrees| *degrees <= most)?;
    let value = degrees * 10_000_000 + (decimal(minutes, 7)? + 30) / 60;
    (value <= most * 10_000_000).then_some(value)
}

/// Reads `hhmmss` with an optional fraction, as ms of the day.
#[inline(never)]
fn time(text: &[u8]) -> Option<i32> {
    let (hours, rest) = text.split_at_checked(2)?;
    let (minutes, seconds) = rest.split_at_checked(2)?;
    let two = |text: &[u8]| match text {
        [tens @ b'0'..=b'9', ones @ b'0'..=b'9'] => {
            Some(10 * i32::from(tens - b'0') + i32::from(ones - b'0'))
        }
        _ => None,
    };
    let &[b'0'..=b'9', b'0'..=b'9', ref fraction @ ..] = seconds else {
        return None;
    };
    if !matches!(fraction, [] | [b'.', ..]) {
        return None;
    }
    let (hours, minutes, milliseconds) = (two(hours)?, two(minutes)?, decimal(seconds, 3)?);
    // A leap second is second 60.
    (hours < 24 && minutes < 60 && milliseconds < 61_000)
        .then(|| (hours * 60 + minutes) * 60_000 + milliseconds)
}
