// Words about who is signed in.
import type { Caller } from "../../api/types";
import { word } from "../../languages/words";

export const people = {
  mayLook: (name: string) => word("app.people.mayLook", { name }),
  who: (name: string) => word("app.people.who", { name }),
  roles: { look: word("app.people.roles.look"), plan: word("app.people.roles.plan"), administer: word("app.people.roles.administer") } satisfies Record<Caller["role"], string>,
  soonOver: word("app.people.soonOver"),
};
