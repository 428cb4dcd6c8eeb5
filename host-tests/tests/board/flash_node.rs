//! Tests what `cargo flash-node` prints and refuses.

#[cfg(unix)]
use crate::executed::{armed_axle, panic_instruction};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Empty folder of one test.
fn folder(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(test);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("a folder");
    path
}

/// Runs the command with `path` as the only place of programs, or the usual ones. Returns whether
/// it succeeded, and its outputs.
fn flash_node(arguments: &[&str], path: Option<&Path>) -> (bool, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_flash_node"));
    command.args(arguments);
    if let Some(path) = path {
        command.env("PATH", path);
    }
    let output = command.output().expect("it starts");
    let texts = [output.stdout, output.stderr].concat();
    let text = String::from_utf8(texts).expect("a text");
    (output.status.success(), text)
}

#[test]
fn without_probe_rs_one_line_says_how_to_install_it() {
    let (done, text) = flash_node(&["axle"], Some(&folder("no-probe-rs")));
    assert!(!done);
    assert_eq!(
        text,
        "cargo flash-node: probe-rs is not installed; type: cargo install probe-rs-tools \
         --locked\n"
    );
}

#[test]
#[cfg(unix)]
fn without_a_probe_one_line_says_what_to_connect() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder("no-probe");
    let program = folder.join("probe-rs");
    // What probe-rs prints when it finds none.
    fs::write(&program, "#!/bin/sh\necho No debug probes were found.\n").expect("a program");
    fs::set_permissions(&program, PermissionsExt::from_mode(0o755)).expect("executable");
    let (done, text) = flash_node(&["axle"], Some(&folder));
    assert!(!done);
    assert_eq!(
        text,
        "cargo flash-node: no debug probe is connected: connect the USB cable of the board's \
         ST-LINK\n"
    );
}

#[test]
#[cfg(unix)]
fn option_bytes_that_let_the_pin_decide_are_named_and_set() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder("option-bytes");
    let [program, options, calls] = ["probe-rs", "options", "calls"].map(|name| folder.join(name));
    // A probe whose chip has one register. It ends when the program is to be written.
    let script = format!(
        "#!/bin/sh\necho \"$@\" >> {calls}\ncase \"$1 $5\" in\n'list '*) echo '[0]: STLink';;\n\
         'read 0x40022020') read word < {options}; echo $word;;\n\
         'write 0x40022020') echo $6 > {options};;\n'write '*) ;;\n*) exit 1;;\nesac\n",
        calls = calls.display(),
        options = options.display(),
    );
    fs::write(&program, script).expect("a program");
    fs::set_permissions(&program, PermissionsExt::from_mode(0o755)).expect("executable");
    let usual = std::env::var("PATH").expect("a path");
    let path = format!("{}:{usual}", folder.display());
    let run = |word: &str, more: &[&str]| {
        fs::write(&options, word).expect("a file");
        fs::write(&calls, "").expect("a file");
        let (_, text) = flash_node(&[&["axle"], more].concat(), Some(Path::new(&path)));
        let set = fs::read_to_string(&options).expect("a file");
        let calls = fs::read_to_string(&calls).expect("a file");
        (text, set.trim().to_owned(), calls)
    };
    // The pin decides, as after an erase of the option bytes.
    let (text, set, _) = run("ffeff8aa", &[]);
    assert!(text.contains("add --set-option-bytes"), "{text}");
    assert_eq!(set, "ffeff8aa");
    let (_, set, calls) = run("ffeff8aa", &["--set-option-bytes"]);
    assert_eq!(set, "0xfbeff8aa");
    // The keys in the order of RM0440, then the start of programming.
    let order = [
        "0x45670123",
        "0xcdef89ab",
        "0x08192a3b",
        "0x4c5d6e7f",
        "0x00020000",
    ];
    let places = order.map(|word| calls.find(word).expect("a key"));
    assert!(places.is_sorted(), "{calls}");
    // As the factory sets them.
    let (text, _, calls) = run("fbeff8aa", &["--set-option-bytes"]);
    assert!(!text.contains("option bytes"), "{text}");
    assert!(!calls.contains("write"), "{calls}");
    // A protected chip would be erased.
    let (text, set, _) = run("ffeff8bb", &["--set-option-bytes"]);
    assert!(text.contains("protected"), "{text}");
    assert_eq!(set, "ffeff8bb");
}

#[test]
fn a_dry_run_prints_sections_settings_and_commands() {
    let (done, text) = flash_node(
        &["axle", "--robot", "b2p2", "--node-id", "3", "--dry-run"],
        None,
    );
    assert!(done, "{text}");
    for part in [
        "0x08000000 ",
        "0x08004000 ",
        "0x0801e000   8192 bytes",
        "  node_id = 3 1",
        "probe-rs download --chip STM32G431CBTx --binary-format elf ",
        "probe-rs download --chip STM32G431CBTx --binary-format bin --base-address 0x0801e000 ",
        "probe-rs reset --chip STM32G431CBTx",
    ] {
        assert!(text.contains(part), "{part} is not in:\n{text}");
    }
}

#[test]
fn a_node_of_another_role_is_refused_with_those_that_have_the_role() {
    let refused = |arguments: &[&str], why: &str| {
        let (done, text) = flash_node(arguments, None);
        assert!(!done);
        assert_eq!(text, format!("cargo flash-node: {why}\n"));
    };
    refused(
        &["screw", "--robot", "b2p2", "--node-id", "2", "--dry-run"],
        "node 2 of B2P2 has not the role screw; these have: 5 (screw)",
    );
    refused(
        &["axle", "--robot", "crawler", "--node-id", "9", "--dry-run"],
        "node 9 of crawler has not the role axle; these have: 2 (left_track), 3 (right_track)",
    );
    refused(
        &["screw", "--robot", "hylos", "--node-id", "2", "--dry-run"],
        "node 2 of Hylos has not the role screw; these have: none",
    );
}

#[test]
fn a_dump_gives_the_settings_of_the_named_node_alone() {
    let dump = folder("dump").join("robot.toml");
    let text = "[[node]]\nid = 2\nidentity = [0, 1, 1, 2]\n[node.settings]\nvelocity_gain = 2500\n\
                [[node]]\nid = 5\nidentity = [0, 2, 1, 5]\n[node.settings]\nvelocity_gain = 1700\n";
    fs::write(&dump, text).expect("a file");
    let path = dump.to_str().expect("a text");
    let run = |more: &[&str]| {
        let arguments = [&["axle", "--dry-run", "--settings", path], more].concat();
        flash_node(&arguments, None)
    };

    let (done, text) = run(&["--node-id", "2"]);
    assert!(done, "{text}");
    assert!(text.contains("velocity_gain = 2500"), "{text}");
    assert!(!text.contains("1700"), "{text}");

    for (arguments, why) in [
        (
            &["--node-id", "5"][..],
            "node 5 has the product code 2; the role axle has 1",
        ),
        (&["--node-id", "7"], "it has no node 7; it has 2, 5"),
        (&[], "name one of its nodes with --node-id: 2, 5"),
    ] {
        let (done, text) = run(arguments);
        assert!(!done);
        assert_eq!(text, format!("cargo flash-node: {path}: {why}\n"));
    }
}

#[test]
fn settings_that_the_board_does_not_bear_are_refused_by_name() {
    let file = folder("beyond").join("motor.toml");
    let refused = |line: &str, why: &str| {
        fs::write(&file, format!("{line}\n")).expect("a file");
        let path = file.to_str().expect("a text");
        let (done, text) = flash_node(&["axle", "--settings", path, "--dry-run"], None);
        assert!(!done, "{line}");
        assert_eq!(text, format!("cargo flash-node: {why}\n"));
    };
    refused(
        "over_voltage = 32000",
        "over_voltage = 32000, this board allows 12000 to 26000",
    );
    refused(
        "dead_time = 0",
        "dead_time = 0, this board allows 300 to 600",
    );
    refused(
        "bridge_temperature = 0",
        "bridge_temperature = 0, this board allows 400 to 1000",
    );
    refused(
        "brake_release_time = 40",
        "brake_release_time = 40, this board allows 0 to 0",
    );
    // The default motor has 2.4 V s/rad: at 120 % of 12 rad/s 34.6 V: 38.0 V with 10 %.
    refused(
        "velocity_limit = 12000",
        "supply if the bridge opens at 120 % of velocity_limit = 38.0 V, at most 36.0 V on this \
         board",
    );
}

/// The motor board's RAM after an over-voltage, a panic, and the reset by the watchdog.
#[cfg(unix)]
fn ram_after_faults() -> Vec<u8> {
    let mut chip = armed_axle();
    // 32.2 V, behind the divider of 169 and 18 kiloohm.
    chip.pins(|pins| pins.supply = 3_847);
    chip.run(3_000);
    chip.pins(|pins| pins.supply = 2_866);
    chip.jump(panic_instruction());
    chip.run(110_000);
    chip.memory(0x2000_0000, 32 * 1024)
}

#[test]
#[cfg(unix)]
fn the_last_faults_of_the_board_are_printed_in_words() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder("faults");
    let [program, memory] = ["probe-rs", "memory"].map(|name| folder.join(name));
    let script = format!(
        "#!/bin/sh\ncase \"$*\" in\nlist) echo '[0]: STLink';;\n\
         'read --chip STM32G431CBTx b32 0x20000000 8192') while read l; do echo $l; done < {};;\n\
         *) exit 1;;\nesac\n",
        memory.display()
    );
    fs::write(&program, script).expect("a program");
    fs::set_permissions(&program, PermissionsExt::from_mode(0o755)).expect("executable");
    let run = |ram: &[u8], behind_addresses: bool| {
        let lines = ram
            .as_chunks::<4>()
            .0
            .chunks(4)
            .zip((0x2000_0000_u32..).step_by(16));
        let text: Vec<String> = lines
            .map(|(words, address)| {
                let start = if behind_addresses {
                    format!("{address:08x}: ")
                } else {
                    String::new()
                };
                let words: Vec<_> = words
                    .iter()
                    .map(|word| format!("{:08x}", u32::from_le_bytes(*word)))
                    .collect();
                format!("{start}{}\n", words.join(" "))
            })
            .collect();
        fs::write(&memory, text.concat()).expect("a file");
        flash_node(&["axle", "--faults"], Some(&folder))
    };
    let ram = ram_after_faults();
    for behind_addresses in [false, true] {
        let (done, text) = run(&ram, behind_addresses);
        assert!(done, "{text}");
        let lines: Vec<_> = text.lines().collect();
        let [title, newest, oldest] = lines[..] else {
            panic!("{text}");
        };
        assert!(title.starts_with("fault log, the newest fault first"));
        assert!(
            newest.contains("0x5220") && newest.contains("crystal or program had failed"),
            "{newest}"
        );
        assert!(oldest.starts_with("  0x3210 over-voltage, "), "{oldest}");
        assert!(
            oldest.contains(" s after power-up or a drop of the supply: 32."),
            "{oldest}"
        );
    }
    let (done, text) = run(&vec![0; ram.len()], false);
    assert!(done);
    assert_eq!(
        text,
        "fault log: none, because the power was off or the program is another one\n"
    );
}
