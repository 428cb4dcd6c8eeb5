//! Values of the registers after a reset, as far as an image could notice another one.
//!
//! ST's register description `STM32G431.svd` confirms all of them but two, which say so. Nobody
//! has compared them with the reference manual RM0440 or with a chip. All other registers are 0.

/// Name, address and value, on every chip.
pub const ALL: [(&str, u32, u32); 34] = [
    // The description has 0x63, which are bits of another family. The high-speed oscillator is on
    // and ready: the core runs on it.
    ("RCC.cr", 0x4002_1000, 0x0000_0500),
    ("RCC.icscr", 0x4002_1004, 0x4000_0000),
    ("RCC.cfgr", 0x4002_1008, 0x0000_0005),
    ("RCC.pllcfgr", 0x4002_100c, 0x0000_1000),
    ("RCC.ahb1enr", 0x4002_1048, 0x0000_0100),
    ("RCC.apb1enr1", 0x4002_1058, 0x0000_0400),
    ("PWR.cr1", 0x4000_7000, 0x0000_0200),
    ("PWR.cr3", 0x4000_7008, 0x0000_8000),
    ("PWR.cr5", 0x4000_7080, 0x0000_0100),
    // The description has one wait state more; the images write the register.
    ("FLASH.acr", 0x4002_2000, 0x0004_0600),
    ("SYSCFG.cfgr1", 0x4001_0004, 0x7c00_0001),
    ("FDCAN1.crel", 0x4000_6400, 0x3214_1218),
    ("FDCAN1.endn", 0x4000_6404, 0x8765_4321),
    ("FDCAN1.dbtp", 0x4000_640c, 0x0000_0a33),
    ("FDCAN1.cccr", 0x4000_6418, 0x0000_0001),
    ("FDCAN1.nbtp", 0x4000_641c, 0x0600_0a03),
    ("FDCAN1.tocc", 0x4000_6428, 0xffff_0000),
    ("FDCAN1.tocv", 0x4000_642c, 0x0000_ffff),
    ("FDCAN1.psr", 0x4000_6444, 0x0000_0707),
    ("FDCAN1.xidam", 0x4000_6484, 0x1fff_ffff),
    ("TIM1.arr", 0x4001_2c2c, 0x0000_ffff),
    ("TIM1.af1", 0x4001_2c60, 0x0000_0001),
    ("TIM1.af2", 0x4001_2c64, 0x0000_0001),
    ("TIM2.arr", 0x4000_002c, 0xffff_ffff),
    ("TIM4.arr", 0x4000_082c, 0x0000_ffff),
    ("IWDG.rlr", 0x4000_3008, 0x0000_0fff),
    ("IWDG.winr", 0x4000_3010, 0x0000_0fff),
    ("ADC1.cr", 0x5000_0008, 0x2000_0000),
    ("ADC2.cr", 0x5000_0108, 0x2000_0000),
    ("GPIOA.moder", 0x4800_0000, 0xabff_ffff),
    ("GPIOA.pupdr", 0x4800_000c, 0x6400_0000),
    ("GPIOB.moder", 0x4800_0400, 0xffff_febf),
    ("GPIOB.pupdr", 0x4800_040c, 0x0000_0100),
    ("GPIOC.moder", 0x4800_0800, 0xffff_ffff),
];

/// The same, on the STM32G474 alone. They come from the reference manual.
pub const G474: [(&str, u32, u32); 3] = [
    // Two banks.
    ("FLASH.optr", 0x4002_2020, 0xffef_f8aa),
    ("USART1.isr", 0x4001_381c, 0x0000_00c0),
    ("I2C3.isr", 0x4000_7818, 0x0000_0001),
];
