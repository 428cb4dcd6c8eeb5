//! Tests which band follows from which margins, and when.

use tautrack::settings::Settings;
use tautrack::stability::bands::{Band, Bands};
use tautrack::stability::parameters::Parameters;

const BANDS: [Band; 4] = [Band::Free, Band::Caution, Band::Limit, Band::Stop];

fn parameters() -> Parameters {
    Parameters::new(&Settings::default())
}

fn run(bands: &mut Bands, margin: f32, samples: usize) -> Band {
    let parameters = parameters();
    for _ in 0..samples {
        bands.update(&[0.3, 0.3, margin, 0.3], 4e-3, &parameters);
    }
    bands.band()
}

/// Bands after a second with this margin.
fn settled(margin: f32) -> Bands {
    let mut bands = Bands::default();
    run(&mut bands, margin, 250);
    bands
}

#[test]
fn a_margin_at_a_level_is_not_below_it() {
    let Parameters {
        caution,
        stop,
        trip,
        ..
    } = parameters();
    for (before, level, band) in [
        (0.2, caution, Band::Free),
        (caution - 0.01, stop, Band::Caution),
        (stop - 0.005, trip, Band::Limit),
    ] {
        let mut bands = settled(before);
        assert_eq!(run(&mut bands, level, 100), band);
        assert!(run(&mut bands, level - 1e-4, 100) > band);
    }
}

/// However long the robot was in a band, the dwell time of the next one begins with its first
/// sample.
#[test]
fn a_change_takes_the_whole_dwell_time_whenever_it_begins() {
    for more in 0..30 {
        let mut bands = settled(0.2);
        run(&mut bands, 0.2, more);
        assert_eq!(run(&mut bands, 0.005, 20), Band::Free, "{more}");
        let mut bands = settled(0.035);
        run(&mut bands, 0.035, more);
        assert_eq!(run(&mut bands, 0.3, 20), Band::Limit, "{more}");
        assert_eq!(run(&mut bands, 0.3, 6), Band::Free, "{more}");
    }
}

#[test]
fn on_the_edge_itself_there_is_no_excursion() {
    let mut bands = settled(0.2);
    assert_eq!(run(&mut bands, 0.0, 3), Band::Free);
    assert_eq!(run(&mut bands, -1e-4, 2), Band::Stop);
}

#[test]
fn a_period_of_no_time_changes_nothing() {
    for period in [0.0, -1.0, f32::NAN] {
        let mut bands = settled(0.2);
        for _ in 0..10 {
            bands.update(&[-0.3; 4], period, &parameters());
        }
        assert_eq!(bands.band(), Band::Free, "{period}");
    }
}

#[test]
fn every_band_has_its_number_and_its_name() {
    for (byte, band) in (0..).zip(BANDS) {
        assert_eq!((band as u8, Band::from_byte(byte)), (byte, Some(band)));
    }
    assert_eq!(Band::from_byte(4), None);
    let names = BANDS.map(Band::name);
    assert_eq!(names, ["free", "caution", "limit", "stop"]);
}
