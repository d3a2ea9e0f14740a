//! The view's answers to keys.

use super::*;

#[test]
fn keys_become_actions_on_the_selected_schema() {
    let app = Fixed::new();
    let mut screen = app.screen();
    press(&mut screen, &app, &typed("jjpsfr+-"));
    let expected = [
        ScreenAction::Play(2),
        ScreenAction::Stop(2),
        ScreenAction::Force(2),
        ScreenAction::Release(2),
        ScreenAction::Period(2, 82_500_000),
        ScreenAction::Period(2, 68_182_000),
    ];
    assert_eq!(*app.acts.borrow(), expected);
    assert_eq!(
        line(&lines(&mut screen, 80, 24), "now runs"),
        "goon now runs every 68.182 ms"
    );
}

#[test]
fn r14_space_stops_everything_and_never_releases_it() {
    let app = Fixed::new();
    let mut screen = app.screen();
    press(&mut screen, &app, &typed("  g"));
    assert_eq!(
        *app.acts.borrow(),
        [
            ScreenAction::StopAll,
            ScreenAction::StopAll,
            ScreenAction::ReleaseAll
        ]
    );
}

#[test]
fn r14_schemas_stopped_by_stop_all_are_shown_with_the_key_that_releases_them() {
    let app = Fixed::new();
    let mut screen = app.screen();
    let edges = |screen: &mut ViewState| {
        let lines = lines(screen, 80, 24);
        (lines[0].clone(), lines[23].clone())
    };
    let (title, keys) = edges(&mut screen);
    assert!(title.contains("running") && keys.contains("space STOP ALL"));
    let hold = Hold {
        with_everything: true,
        ..held(HoldKind::Stopped).unwrap()
    };
    app.snapshot.borrow_mut().schemas[0].operator = Some(hold);
    screen.observe(&app);
    press(&mut screen, &app, &typed("j"));
    let (title, keys) = edges(&mut screen);
    assert!(title.contains("STOPPED by ana@laptop  "), "{title}");
    assert!(keys.contains("g GO ON") && !keys.contains("STOP ALL"), "{keys}");
}

#[test]
fn r14_a_key_that_is_pressed_again_does_the_same_again() {
    let app = Fixed::new();
    for (state, hold) in [
        (State::Winner, None),
        (State::Slept, held(HoldKind::Stopped)),
        (State::Winner, held(HoldKind::Forced)),
    ] {
        let mut screen = app.screen();
        app.snapshot.borrow_mut().schemas[2].operator = hold;
        app.snapshot.borrow_mut().schemas[2].state = state;
        screen.observe(&app);
        app.acts.borrow_mut().clear();
        press(&mut screen, &app, &typed("jjssppff"));
        let acts = [
            ScreenAction::Stop(2),
            ScreenAction::Play(2),
            ScreenAction::Force(2),
        ];
        let twice: Vec<_> = acts.iter().flat_map(|act| [*act; 2]).collect();
        assert_eq!(*app.acts.borrow(), twice);
    }
}

#[test]
fn a_refusal_is_shown_until_the_next_key() {
    let app = Fixed {
        refuses: Some("`pioneer` competes with nobody"),
        ..Fixed::new()
    };
    let mut screen = app.screen();
    press(&mut screen, &app, &typed("f"));
    assert!(
        lines(&mut screen, 80, 24)
            .join("\n")
            .contains("`pioneer` competes with nobody")
    );
    press(&mut screen, &app, &typed("j"));
    assert!(
        !lines(&mut screen, 80, 24)
            .join("\n")
            .contains("competes with nobody")
    );
}

#[test]
fn a_typed_period_is_set_and_a_wrong_one_is_explained() {
    let app = Fixed::new();
    let mut screen = app.screen();
    press(&mut screen, &app, &typed("t75"));
    press(&mut screen, &app, &[KeyCode::Enter]);
    let shown = line(&lines(&mut screen, 80, 24), "new period of teleop: 75");
    assert!(shown.contains("needs a unit"), "{shown}");
    assert!(app.acts.borrow().is_empty());
    press(&mut screen, &app, &[KeyCode::Backspace]);
    press(&mut screen, &app, &typed("0ms"));
    press(&mut screen, &app, &[KeyCode::Enter]);
    assert_eq!(*app.acts.borrow(), [ScreenAction::Period(0, 70 * MS)]);
}

#[test]
fn escape_leaves_the_input_and_not_the_view() {
    let app = Fixed::new();
    let mut screen = app.screen();
    press(&mut screen, &app, &typed("tq"));
    assert_eq!(press(&mut screen, &app, &[KeyCode::Esc]), None);
    assert_eq!(press(&mut screen, &app, &[KeyCode::Esc]), Some(ExitReason::Quit));
    assert!(app.acts.borrow().is_empty());
}

#[test]
fn help_opens_and_any_key_closes_it() {
    let app = Fixed::new();
    let mut screen = app.screen();
    press(&mut screen, &app, &typed("?"));
    assert!(lines(&mut screen, 80, 24).join("\n").contains("force it to win"));
    assert_eq!(press(&mut screen, &app, &typed("q")), None);
    assert!(!lines(&mut screen, 80, 24).join("\n").contains("force it to win"));
}

#[test]
fn control_c_leaves_from_everywhere() {
    let app = Fixed::new();
    for keys in ["", "?", "t12"] {
        let mut screen = app.screen();
        press(&mut screen, &app, &typed(keys));
        let exit_reason = screen.handle_key(&app, KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL));
        assert_eq!(exit_reason, Some(ExitReason::Quit), "after “{keys}”");
    }
}

#[test]
fn an_ended_application_is_shown_until_the_user_leaves() {
    let app = Fixed::new();
    let mut screen = app.screen();
    assert_eq!(press(&mut screen, &app, &[KeyCode::Enter]), None);
    *app.ending.borrow_mut() = Some(Ending::Known(Outcome::Done));
    screen.observe(&app);
    let ended = screen.snapshot.time;
    app.snapshot.borrow_mut().time += 60_000 * MS;
    screen.observe(&app);
    assert_eq!(screen.snapshot.time, ended, "its clock stands still");
    assert!(lines(&mut screen, 80, 24)[0].contains(" done "));
    let text = lines(&mut screen, 80, 24).join("\n");
    assert!(text.contains("done: the mission is done. Press Enter"), "{text}");
    *app.ending.borrow_mut() = Some(Ending::Lost);
    screen.observe(&app);
    assert!(lines(&mut screen, 80, 24)[0].contains(" lost "));
    let exit_reason = press(&mut screen, &app, &[KeyCode::Enter]);
    assert_eq!(exit_reason, Some(ExitReason::Ended));
}

#[test]
fn an_application_that_says_nothing_is_not_shown_as_running() {
    let app = Fixed::new();
    let mut screen = app.screen();
    assert!(lines(&mut screen, 80, 24)[0].contains("running"));
    app.silent.set(Duration::from_millis(3500));
    screen.observe(&app);
    let title = lines(&mut screen, 80, 24)[0].clone();
    assert!(
        title.contains("NO NEWS for 3 s") && !title.contains("running"),
        "{title}"
    );
}
