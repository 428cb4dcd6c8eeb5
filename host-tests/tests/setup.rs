//! Tests the setup of the host: what a computer lacks is installed if that is allowed, else one
//! line names it.

use proptest::prelude::*;
use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tautrack::link::{FromNode, Prefix, Start, ToNode, VERSION};
use tautrack_host_tests::programs::setup::plan::{Packages, after, plan};
use tautrack_host_tests::programs::setup::{
    Facts, Missing, QEMU, Rights, Step, Toolchain, checkout,
};
use tautrack_host_tests::programs::{Board, changes_a_build};
use tautrack_host_tests::robots::Kind;

const READY: Facts = Facts {
    target_library: true,
    library_sources: true,
    sources_needed: true,
    rustup: true,
    distribution_rust: false,
    distribution_wanted: false,
    qemu: true,
    packages: Some(Packages::Apt),
    rights: Some(Rights::Root),
    setup_allowed: true,
};

fn facts() -> impl Strategy<Value = Facts> {
    let packages = prop_oneof![
        Just(None),
        Just(Some(Packages::Apt)),
        Just(Some(Packages::Dnf))
    ];
    let rights = prop_oneof![
        Just(None),
        Just(Some(Rights::Root)),
        Just(Some(Rights::Sudo))
    ];
    (any::<[bool; 8]>(), packages, rights).prop_map(|(bits, packages, rights)| Facts {
        target_library: bits[0],
        rustup: bits[1],
        distribution_rust: bits[2],
        distribution_wanted: bits[3],
        qemu: bits[4],
        packages,
        rights,
        setup_allowed: bits[5],
        library_sources: bits[6],
        sources_needed: bits[7],
    })
}

#[test]
fn nothing_is_installed_on_a_machine_that_has_all() {
    assert_eq!(plan(&READY), Ok((Toolchain::Current, vec![])));
}

#[test]
fn rustup_is_asked_first_for_a_missing_target_and_the_distribution_when_that_fails() {
    let bare = Facts {
        target_library: false,
        ..READY
    };
    assert_eq!(plan(&bare), Ok((Toolchain::Current, vec![Step::AddTarget])));
    let failed = after(Step::AddTarget, false, &bare, &bare);
    let install = Step::InstallDistributionRust(Rights::Root);
    assert_eq!(plan(&failed), Ok((Toolchain::Distribution, vec![install])));
    let hopeless = after(install, false, &failed, &bare);
    assert_eq!(plan(&hopeless), Err(Missing::Target));
}

#[test]
fn a_flash_image_gets_the_sources_of_the_library_and_a_simulated_node_does_not_need_them() {
    let bare = Facts {
        library_sources: false,
        ..READY
    };
    assert_eq!(
        plan(&bare),
        Ok((Toolchain::Current, vec![Step::AddSources]))
    );
    let simulated = Facts {
        sources_needed: false,
        ..bare
    };
    assert_eq!(plan(&simulated), Ok((Toolchain::Current, vec![])));
    let forbidden = Facts {
        setup_allowed: false,
        ..bare
    };
    assert_eq!(plan(&forbidden), Err(Missing::Sources));
    let nothing = Facts {
        target_library: false,
        ..bare
    };
    let steps = vec![Step::AddTarget, Step::AddSources];
    assert_eq!(plan(&nothing), Ok((Toolchain::Current, steps)));
    // Without a network, rustup fails, and the distribution's packages have the sources.
    let failed = after(Step::AddSources, false, &bare, &bare);
    let install = Step::InstallDistributionRust(Rights::Root);
    assert_eq!(plan(&failed), Ok((Toolchain::Distribution, vec![install])));
}

#[test]
fn the_distribution_is_taken_when_it_is_asked_for() {
    let asked = Facts {
        distribution_wanted: true,
        distribution_rust: true,
        ..READY
    };
    assert_eq!(plan(&asked), Ok((Toolchain::Distribution, vec![])));
    let forbidden = Facts {
        distribution_rust: false,
        setup_allowed: false,
        ..asked
    };
    assert_eq!(plan(&forbidden), Err(Missing::DistributionRust));
}

#[test]
fn commands_use_the_rights_there_are() {
    let step = Step::InstallQemu(Packages::Dnf, Rights::Sudo);
    assert_eq!(
        step.commands(),
        [["sudo", "-n", "dnf", "install", "-y", QEMU]]
    );
    assert!(
        step.to_string()
            .ends_with("sudo -n dnf install -y qemu-system-arm")
    );
}

#[test]
fn what_is_missing_is_one_line_that_says_what_to_type() {
    for missing in [
        Missing::Target,
        Missing::Sources,
        Missing::DistributionRust,
        Missing::Qemu,
    ] {
        let text = missing.to_string();
        assert!(
            text.contains("type") && text.contains("apt-get install") && !text.contains('\n'),
            "{text}"
        );
    }
    let qemu = Missing::Qemu.to_string();
    assert!(
        qemu.contains("dnf install qemu-system-arm") && qemu.contains("brew install qemu"),
        "{qemu}"
    );
}

proptest! {
    #[test]
    fn nothing_is_ever_installed_when_that_is_forbidden(facts in facts()) {
        let facts = Facts { setup_allowed: false, ..facts };
        if let Ok((_, steps)) = plan(&facts) {
            prop_assert_eq!(steps, vec![]);
        }
    }

    #[test]
    fn setting_up_ends_even_when_every_step_fails(facts in facts()) {
        let mut now = facts;
        for _ in 0..4 {
            match plan(&now) {
                Ok((_, steps)) if !steps.is_empty() => now = after(steps[0], false, &now, &facts),
                _ => return Ok(()),
            }
        }
        prop_assert!(false, "still trying: {now:?}");
    }
}

/// Makes a folder that looks like a checkout, whose default scenario is bad and contains `name`.
fn checkout_in(parent: &Path, name: &str) -> PathBuf {
    let root = parent.join(name);
    fs::create_dir_all(root.join("firmware/dictionary")).unwrap();
    fs::create_dir_all(root.join("host-tests/scenarios")).unwrap();
    fs::write(root.join("Cargo.toml"), "").unwrap();
    let scenario = root.join("host-tests/scenarios/staircase.toml");
    fs::write(scenario, format!("name = \"{name}\"\n")).unwrap();
    root.canonicalize().unwrap()
}

#[test]
fn the_checkout_is_the_first_at_or_above_the_places() {
    let parent = Path::new(env!("CARGO_TARGET_TMPDIR")).join("checkouts");
    let [first, second] = ["first", "second"].map(|name| checkout_in(&parent, name));
    let deep = second.join("host-tests/scenarios");
    let none = PathBuf::from("/nowhere/at/all");
    for (places, expected) in [
        (vec![first.clone(), second.clone()], &first),
        (vec![second.clone(), first.clone()], &second),
        (vec![none.clone(), deep.clone(), first.clone()], &second),
        (vec![deep.join("no/such/folder")], &second),
    ] {
        assert_eq!(
            checkout::find(places.clone()).as_ref(),
            Ok(expected),
            "{places:?}"
        );
    }
    let error = checkout::find([none.clone()]).unwrap_err();
    assert!(error.to_string().contains("/nowhere/at/all"), "{error}");
}

/// Runs the demo in `folder`, with cargo's variable for the package if given, and returns its
/// error.
fn error_in(program: &Path, folder: &Path, package: Option<&Path>) -> String {
    let mut command = Command::new(program);
    command.current_dir(folder).env_remove("CARGO_MANIFEST_DIR");
    if let Some(package) = package {
        command.env("CARGO_MANIFEST_DIR", package);
    }
    let output = command.output().unwrap();
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    error
}

#[test]
fn a_copied_checkout_reads_its_own_scenarios() {
    let parent = Path::new(env!("CARGO_TARGET_TMPDIR")).join("copies");
    let [mine, other] = ["mine", "other"].map(|name| checkout_in(&parent, name));
    let demo = Path::new(env!("CARGO_BIN_EXE_demo"));
    let names = |error: &str, root: &Path| error.contains(&root.display().to_string());
    let error = error_in(demo, &mine, None);
    assert!(names(&error, &mine), "{error}");
    // If cargo starts the program, the checkout is the one of the package, in any working
    // directory.
    let error = error_in(demo, &mine, Some(&other.join("host-tests")));
    assert!(names(&error, &other), "{error}");
}

#[test]
fn without_a_checkout_the_error_says_where_it_was_looked_for() {
    let folder = std::env::temp_dir().join(format!("tautrack-nowhere-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let demo = folder.join("demo");
    fs::copy(env!("CARGO_BIN_EXE_demo"), &demo).unwrap();
    let error = error_in(&demo, &folder, None);
    fs::remove_dir_all(&folder).unwrap();
    assert!(error.contains("no tautrack checkout"), "{error}");
    assert!(error.contains("tautrack-nowhere"), "{error}");
}

#[test]
fn surroundings_of_cargo_do_not_reach_the_build_of_the_nodes() {
    for name in [
        "CARGO_ENCODED_RUSTFLAGS",
        "CARGO_PROFILE_FIRMWARE_LTO",
        "RUSTFLAGS",
        "RUSTC_WRAPPER",
        "DEFMT_LOG",
    ] {
        assert!(changes_a_build(name.as_ref()), "{name}");
    }
    for name in [
        "PATH",
        "CARGO_HOME",
        "CARGO_HTTP_CAINFO",
        "CARGO_NET_OFFLINE",
        "RUSTUP_TOOLCHAIN",
        "HTTPS_PROXY",
    ] {
        assert!(!changes_a_build(name.as_ref()), "{name}");
    }
}

#[test]
fn nodes_are_built_and_answer_in_qemu() {
    let programs = Kind::B2p2
        .programs(Board::Qemu)
        .unwrap_or_else(|error| panic!("{error}"));
    let program = &programs.nodes;
    assert_eq!(program.sha256.len(), 64);
    for role in ["axle", "screw", "guard"] {
        let mut node = Command::new(QEMU)
            .args([
                "-M",
                "mps2-an386",
                "-nographic",
                "-monitor",
                "none",
                "-serial",
                "none",
            ])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(&program.path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let start = Start {
            version: VERSION,
            seed: 1,
            flash: heapless::String::new(),
            settings: heapless::Vec::new(),
            motor: None,
            role: role.try_into().unwrap(),
        };
        let body = postcard::to_allocvec(&ToNode::Start(start)).unwrap();
        let mut input = node.stdin.take().unwrap();
        let length = body.len() as u16;
        let prefix = Prefix { length, node: 0 };
        input.write_all(&prefix.to_bytes()).unwrap();
        input.write_all(&body).unwrap();
        let mut output = node.stdout.take().unwrap();
        let mut prefix = [0; Prefix::BYTES];
        output.read_exact(&mut prefix).unwrap();
        let mut body = vec![0; usize::from(Prefix::from_bytes(prefix).length)];
        output.read_exact(&mut body).unwrap();
        let FromNode::Ready(ready) = postcard::from_bytes(&body).unwrap() else {
            panic!("{role} does not begin with Ready");
        };
        assert_eq!(
            (ready.version, ready.role.as_str(), ready.board.as_str()),
            (VERSION, role, "mps2")
        );
        drop(input);
        node.kill().unwrap();
        node.wait().unwrap();
    }
}
