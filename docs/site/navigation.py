"""The pages of the site in the order of its navigation. Sphinx warns of a page that is not here, and a warning fails the build."""

NAVIGATION = [
    (
        "Start",
        [
            "The guide <docs/guide>",
            "docs/gallery",
            "docs/examples/README",
            "docs/examples/blade_loss",
            "docs/examples/chain_to_ring",
            "docs/examples/climbing_robot",
            "docs/examples/crane",
            "docs/examples/debris_tug",
            "docs/examples/excavator_pin",
            "docs/examples/hand_over",
            "docs/examples/hexapod",
            "docs/examples/knee_ligament",
            "docs/examples/line_cascade",
            "docs/examples/solar_array_jam",
            "docs/examples/trapeze_catch",
            "docs/concepts",
            "docs/limits",
            "docs/accuracy-and-speed",
            "docs/install",
        ],
    ),
    (
        "Coming from",
        [
            "MuJoCo <docs/coming-from/mujoco>",
            "Drake <docs/coming-from/drake>",
            "Simbody <docs/coming-from/simbody>",
            "Gazebo <docs/coming-from/gazebo>",
        ],
    ),
    (
        "How to",
        [
            "docs/howto/first-run",
            "docs/howto/write-a-scenario",
            "docs/howto/choose-a-method",
            "docs/howto/look-at-a-run",
            "docs/howto/play",
            "docs/howto/live-view",
            "docs/howto/use-the-results",
            "docs/howto/export",
            "docs/howto/long-runs",
            "docs/howto/generate-code",
            "docs/python",
            "docs/python-gallery",
            "docs/python-sweeps",
            "docs/python-learning",
            "docs/python-bridges",
        ],
    ),
    (
        "Reference",
        [
            "docs/scenario",
            "docs/springs",
            "docs/contact",
            "docs/loops",
            "docs/models",
            "docs/command",
            "docs/results",
            "docs/sweeps",
            "docs/library",
            "docs/batches",
            "docs/site/cpp/index",
            "docs/site/python",
        ],
    ),
    (
        "Background",
        [
            "docs/theory",
            "docs/verification",
            "docs/squeezer",
            "bench/README",
            "bench/peers/README",
            "bench/peers/contact/README",
            "bench/results/peers",
            "docs/versions",
            "docs/adr/README",
            "docs/README",
        ],
    ),
    (
        "Project",
        ["ARCHITECTURE", "CHANGELOG", "CONTRIBUTING", "SECURITY", "packaging/README", "wasm/npm/README", "tests/data/README"],
    ),
]

# Pages below a page of the navigation.
BELOW = {
    "docs/adr/README": "0*",
}
