// All that a person or the address can ask of the page: the actions of its features put together.
import type { Client } from "../api/client";
import type { Frame } from "../api/types";
import { checkActions } from "../checks/actions";
import { drawingActions } from "../drawing/actions";
import { handleActions } from "../drawing/patterns/handles";
import { fitActions } from "../fit/actions";
import { createFollower } from "../fit/playback/follower";
import { createPlayer } from "../fit/playback/playback";
import { landmarkActions } from "../landmarks/actions";
import { sizeActions } from "../landmarks/size/actions";
import { isSizeLast, isSizeNext } from "../landmarks/size/ruler";
import { createProposalSearch } from "../landmarks/proposals/proposalSearch";
import { patientActions } from "../patients/actions";
import { planActions } from "../plan/actions";
import { scanActions } from "../scan/actions";
import { shareActions } from "../share/actions";
import { foundActions } from "../stances/found/actions";
import { stancesActions } from "../stances/actions";
import { visitsActions } from "../stances/visits/actions";
import { createOutbox, type Outbox } from "../store/outbox";
import { messageOf, withProblem } from "../store/problems";
import type { Store } from "../store/store";
import { viewActions } from "../viewer/actions";
import { bringActions } from "./bring";
import { deletionActions } from "./deletion/actions";
import { exportActions } from "./exportActions";
import { keepTrying } from "./keepTrying";
import { leavingActions } from "./leaving";
import { pageActions } from "./pageActions";
import { CHANGES, forPerson } from "./people/reader";
import { scanContents } from "./scanContents";
import type { Session } from "./session";

type Given = [client: Client, prefersStill: () => boolean, outbox?: Outbox];

function allActions(store: Store<Session>, ...[client, prefersStill, outbox = createOutbox()]: Given) {
  const player = createPlayer(store, prefersStill);
  const follower = createFollower(store, client);
  const fit = fitActions(store, client, player, follower);
  const proposals = createProposalSearch(store, client);
  const byHand = (): void => {
    fit.setAside();
    proposals.lookOnce();
  };
  const landmarks = landmarkActions(store, client, { begun: byHand, moved: fit.refit, answered: fit.refit }, outbox);
  const plan = planActions(store, client, outbox);
  const scan = scanActions(store, client, scanContents(landmarks, plan, fit.stop), outbox);
  const drawing = drawingActions(store, client, plan);
  const leaving = leavingActions(store, { landmarks, lines: drawing }, outbox);
  const guarded = leaving.guarded(scan);
  const stances = stancesActions(store, client, { scan, fit, landmarks, drawing, plan, begin: () => bring.begin() });
  const bring = bringActions(store, client, { scan: guarded, stances, fit, landmarks, plan });
  const size = sizeActions(store, client, {
    flush: () => Promise.all([landmarks.flush(), drawing.flush().then(() => plan.settled()), scan.settled()]),
    reopen: ({ id }) => {
      const shown = store.get().scan;
      return scan.open(id, shown?.frameFrom === "person" ? shown.frame : null);
    },
    cancel: () => fit.cancel(),
    begin: bring.begin,
  });
  /** On the body: picks, and the size in which they are. */
  const body = {
    undo: (): void => (isSizeLast(store.get()) ? void size.undo() : landmarks.undo()),
    redo: (): void => (isSizeNext(store.get()) ? void size.redo() : landmarks.redo()),
  };
  const patients = patientActions(store, client, outbox);
  const deletion = deletionActions(store, client, { scan, fit, stances, patients }, outbox);
  return {
    page: pageActions(store, byHand),
    bring,
    view: viewActions(store),
    scan: { ...guarded, open: (id: string, own: Frame | null) => (deletion.keepIf(id), guarded.open(id, own)) },
    leaving,
    unsaved: keepTrying(store, outbox, [landmarks, plan, scan]),
    deletion,
    landmarks,
    size,
    body,
    drawing,
    handles: handleActions(store, client, drawing.choosePattern),
    plan,
    stances,
    found: foundActions(store, client, landmarks),
    checks: checkActions(store, client, { landmarks, fit, follower, saved: async () => (await drawing.flush(), plan.settled()) }),
    patients,
    share: shareActions(store, client), visits: visitsActions(store, client),
    proposals,
    /** What still waits is saved first; the page that follows asks for the token. */
    async signOut(): Promise<void> {
      if (!(await leaving.mayLeave())) return;
      try {
        await client.signOut();
        outbox.forget(() => true); // nothing of a patient stays in the browser
        location.assign("/sign-in");
      } catch (error) {
        store.set((state) => withProblem(state, "page", messageOf(error)));
      }
    },
    fit,
    follower,
    files: exportActions(store),
    player,
  };
}

export type Actions = ReturnType<typeof allActions>;

export const createActions = (store: Store<Session>, ...given: Given): Actions => forPerson(allActions(store, ...given), store);
CHANGES satisfies { readonly [Room in keyof Actions]?: readonly (keyof Actions[Room])[] };
