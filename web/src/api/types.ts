// The service's words under the names that the page uses.  The shapes themselves are in types.gen.ts.
export interface Problem {
  type?: string;
  title: string;
  status: number;
  detail?: string;
}
