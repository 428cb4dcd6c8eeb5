//! Current, supply voltage and temperature, and the interrupt of the current loop.
//!
//! Each shunt has an op-amp in the chip. TIM1 triggers two converters at the same moment: ADC1
//! converts phases a and c, then supply voltage and temperature; ADC2 converts phase b twice and
//! raises the interrupt. So the interrupt has all currents, and does not wait for the two slow
//! inputs. Below [`bridge::SAMPLED`], an op-amp has settled; the current loop uses two such phases.

use super::analogue::{SUPPLY_PER_CODE, current};
use super::{bridge, encoder};
use crate::current_loop;
use core::sync::atomic::{AtomicU32, Ordering};
use embassy_stm32::adc::{Adc, AdcChannel, AdcConfig, Exten, InjectedAdc, SampleTime};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::opamp::{OpAmp, OpAmpGain, OpAmpOutput, OpAmpSpeed};
use embassy_stm32::peripherals::{
    ADC1, ADC2, OPAMP1, OPAMP2, OPAMP3, PA0, PA1, PA2, PA3, PA5, PA6, PA7, PB0, PB1, PB2, PB14,
};
use embassy_stm32::{Peri, interrupt, pac, triggers};
use static_cell::StaticCell;
use tautrack::motor::bridge::Readings;

/// Pins of the analogue inputs.
pub struct Pins {
    /// Op-amps of the phases.
    pub amplifiers: (
        Peri<'static, OPAMP1>,
        Peri<'static, OPAMP2>,
        Peri<'static, OPAMP3>,
    ),
    /// Positive input, bias and output of the op-amp of phase a.
    pub a: (Peri<'static, PA1>, Peri<'static, PA3>, Peri<'static, PA2>),
    /// The same of phase b.
    pub b: (Peri<'static, PA7>, Peri<'static, PA5>, Peri<'static, PA6>),
    /// The same of phase c.
    pub c: (Peri<'static, PB0>, Peri<'static, PB2>, Peri<'static, PB1>),
    /// Converters of phases a and c, and b.
    pub converters: (Peri<'static, ADC1>, Peri<'static, ADC2>),
    /// Divided supply voltage.
    pub supply: Peri<'static, PA0>,
    /// Divider with the thermistor between the transistors.
    pub temperature: Peri<'static, PB14>,
}

/// Code of the supply voltage above which the current loop opens the bridge.
static HIGHEST_SUPPLY: AtomicU32 = AtomicU32::new(0);

/// Starts op-amps and converters, and enables the current interrupt at the highest priority. The
/// current loop opens the bridge above the supply voltage `over_voltage`, V.
pub fn start(pins: Pins, over_voltage: f32) {
    static AMPLIFIER_A: StaticCell<OpAmp<'static, OPAMP1>> = StaticCell::new();
    static AMPLIFIER_B: StaticCell<OpAmp<'static, OPAMP2>> = StaticCell::new();
    static AMPLIFIER_C: StaticCell<OpAmp<'static, OPAMP3>> = StaticCell::new();
    static A: StaticCell<InjectedAdc<'static, ADC1, 4>> = StaticCell::new();
    static B: StaticCell<InjectedAdc<'static, ADC2, 2>> = StaticCell::new();
    static OUTPUT_A: StaticCell<OpAmpOutput<'static, OPAMP1>> = StaticCell::new();
    static OUTPUT_B: StaticCell<OpAmpOutput<'static, OPAMP2>> = StaticCell::new();
    static OUTPUT_C: StaticCell<OpAmpOutput<'static, OPAMP3>> = StaticCell::new();
    let high_speed = OpAmpSpeed::HighSpeed;
    let (mut output_a, mut output_b, mut output_c) = (pins.a.2, pins.b.2, pins.c.2);
    // Dropping an output switches its op-amp off, so it stays in a static variable, and the
    // converter gets the pin.
    OUTPUT_A.init(
        AMPLIFIER_A
            .init(OpAmp::new(pins.amplifiers.0, high_speed))
            .pga_biased_ext(pins.a.0, pins.a.1, output_a.reborrow(), OpAmpGain::Mul16),
    );
    OUTPUT_B.init(
        AMPLIFIER_B
            .init(OpAmp::new(pins.amplifiers.1, high_speed))
            .pga_biased_ext(pins.b.0, pins.b.1, output_b.reborrow(), OpAmpGain::Mul16),
    );
    OUTPUT_C.init(
        AMPLIFIER_C
            .init(OpAmp::new(pins.amplifiers.2, high_speed))
            .pga_biased_ext(pins.c.0, pins.c.1, output_c.reborrow(), OpAmpGain::Mul16),
    );

    // 0.29 us: the output of an op-amp needs 0.2 us (data sheet of the chip).
    let fast = SampleTime::CYCLES12_5;
    let slow = SampleTime::CYCLES47_5;
    let (adc1, adc2) = pins.converters;
    // SAFETY: both are the same analogue input, which nothing else uses.
    let again = unsafe { output_b.clone_unchecked() };
    B.init(
        Adc::new(adc2, AdcConfig::default()).setup_injected_conversions(
            [(output_b.degrade_adc(), fast), (again.degrade_adc(), fast)],
            triggers::TIM1_TRGO2,
            Exten::RISING_EDGE,
            true,
        ),
    );
    A.init(
        Adc::new(adc1, AdcConfig::default()).setup_injected_conversions(
            [
                (output_a.degrade_adc(), fast),
                (output_c.degrade_adc(), fast),
                (pins.supply.degrade_adc(), slow),
                (pins.temperature.degrade_adc(), slow),
            ],
            triggers::TIM1_TRGO2,
            Exten::RISING_EDGE,
            false,
        ),
    );
    HIGHEST_SUPPLY.store((over_voltage / SUPPLY_PER_CODE) as u32, Ordering::Relaxed);
    interrupt::ADC1_2.set_priority(Priority::P0);
    // SAFETY: the handler is below, and everything that it uses has been started.
    unsafe { interrupt::ADC1_2.enable() };
}

/// The current interrupt.
#[interrupt]
fn ADC1_2() {
    pac::ADC2.isr().write(|w| {
        w.set_jeos(true);
        w.set_jeoc(true);
    });
    let readings = Readings {
        currents: [
            current(pac::ADC1.jdr(0).read().jdata()),
            current(pac::ADC2.jdr(0).read().jdata()),
        ],
        third: Some(current(pac::ADC1.jdr(1).read().jdata())),
        rotor: encoder::update(),
        // The newest conversion: that of this period may be under way.
        over_voltage: u32::from(pac::ADC1.jdr(2).read().jdata())
            > HIGHEST_SUPPLY.load(Ordering::Relaxed),
    };
    bridge::apply(current_loop::pwm_period(&readings));
}

/// Supply voltage, V; 0 before its first conversion.
pub fn supply_voltage() -> f32 {
    let code = f32::from(pac::ADC1.jdr(2).read().jdata());
    code * SUPPLY_PER_CODE
}

/// Temperature between the transistors, degrees Celsius ([`super::thermistor::celsius`]).
pub fn temperature() -> f32 {
    super::thermistor::celsius(pac::ADC1.jdr(3).read().jdata())
}
