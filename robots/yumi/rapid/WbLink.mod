MODULE WbLink
    ! The link to the workbench: abb-socket and abb-socket/2 on one port.
    ! Loaded into T_LINK, a task without motion. docs/protocol.md has both.

    CONST string WB_ADDRESS:="192.168.125.1";
    CONST num WB_PORT:=1025;
    CONST string WB_VERSION:="abb-socket/2";
    CONST string WB_ARMS:="R7 L7";

    CONST num WB_FRAME:=80;
    CONST num WB_TEXT:=75;
    CONST num WB_SILENCE:=2;
    CONST num WB_REPORT:=0.2;
    CONST num WB_FIRST_BYTE:=255;
    CONST num WB_START_TOLERANCE:=0.5;

    ! State, what comes, state after it: the table of docs/protocol.md.
    CONST num WB_ROWS:=27;
    CONST string wb_row{27}:=[
        "greeted hello ready",
        "ready plan loading",
        "loading ticket loading",
        "loading start loading",
        "loading load loading",
        "loading axes loading",
        "loading leg loading",
        "loading to loading",
        "loading end loaded",
        "loaded run running",
        "running done ready",
        "running fault fault",
        "running wait waiting",
        "waiting next running",
        "waiting fault fault",
        "ready ping ready",
        "loading ping loading",
        "loaded ping loaded",
        "running ping running",
        "waiting ping waiting",
        "fault ping fault",
        "ready abort stopped",
        "loading abort stopped",
        "loaded abort stopped",
        "running abort stopped",
        "waiting abort stopped",
        "fault abort stopped"];

    VAR socketdev server;
    VAR socketdev client;
    VAR bool is_connected:=FALSE;
    VAR string state;
    VAR string trouble;
    VAR clock since_heard;
    VAR clock since_report;
    VAR num heard_number;
    VAR num said_number;
    VAR byte table_high{256};
    VAR byte table_low{256};

    ! The sum over one message, and over all that load a program.
    VAR byte sum_high;
    VAR byte sum_low;
    VAR byte all_high;
    VAR byte all_low;

    VAR string word{12};
    VAR num words;
    VAR string ticket;
    PERS string wb_ticket{16};
    PERS num wb_tickets:=0;
    VAR num told_legs;
    VAR num told_points;
    VAR bool is_stepped;
    VAR num open_arm;
    VAR num open_points;
    VAR num started;
    VAR num load_arm;
    VAR num load_of;
    VAR bool part_told{2};

    PROC main()
        fill_tables;
        WHILE TRUE DO
            serve_one;
            stop_arms;
            ! An address that is not there must not keep the controller busy.
            WaitTime 0.1;
        ENDWHILE
    ENDPROC

    ! One client from its connection to its end.
    PROC serve_one()
        VAR string first;

        trouble:="";
        is_connected:=FALSE;
        SocketCreate server;
        SocketBind server,WB_ADDRESS,WB_PORT;
        SocketListen server;
        SocketAccept server,client\Time:=WAIT_MAX;
        SocketClose server;
        is_connected:=TRUE;
        say_plain "send";
        first:=received(7,WAIT_MAX);
        IF NOT is_connected RETURN;
        IF StrFind(first,1,STR_DIGIT)=1 THEN
            serve_program first;
        ELSE
            serve_requests first;
        ENDIF
        IF trouble<>"" TPWrite "Workbench: "+trouble;
        SocketClose client;
    ERROR
        SocketClose server;
        SocketClose client;
        is_connected:=FALSE;
        RETURN;
    ENDPROC

    ! Nothing may go on moving when nobody is there to stop it.
    PROC stop_arms()
        IF wb_ended{1}=wb_order AND wb_ended{2}=wb_order THEN
            ! An abort also stops arms that stand: without this they never move again.
            StopMoveReset\AllMotionTasks;
            RETURN;
        ENDIF
        wb_restarted{1}:=FALSE;
        wb_restarted{2}:=FALSE;
        StopMove\Quick\AllMotionTasks;
        TPWrite "Workbench: stopped. Set the pointer of both arms to main.";
        WaitUntil wb_restarted{1} AND wb_restarted{2};
        StopMoveReset\AllMotionTasks;
    ENDPROC

    ! ---- abb-socket/2 ------------------------------------------------------

    PROC serve_program(string first)
        VAR string frame;

        state:="greeted";
        heard_number:=0;
        said_number:=0;
        frame:=first+received(WB_FRAME-7,WB_SILENCE);
        ClkReset since_report;
        ClkStart since_report;
        IF is_connected take frame;
        WHILE is_connected AND trouble="" AND state<>"stopped" DO
            IF has_frame() THEN
                frame:=received(WB_FRAME,WB_SILENCE);
                IF is_connected take frame;
            ELSE
                WaitTime 0.01;
            ENDIF
            IF state="running" OR state="waiting" watch_arms;
            IF ClkRead(since_report)>WB_REPORT report;
        ENDWHILE
    ENDPROC

    FUNC bool has_frame()
        RETURN SocketPeek(client)>=WB_FRAME;
    ERROR
        is_connected:=FALSE;
        RETURN FALSE;
    ENDFUNC

    PROC take(string frame)
        VAR string after;
        VAR string sum;
        VAR num number;

        sum_high:=WB_FIRST_BYTE;
        sum_low:=WB_FIRST_BYTE;
        add_to_sum StrPart(frame,1,WB_TEXT);
        sum:=ByteToStr(sum_high\Hex)+ByteToStr(sum_low\Hex);
        IF StrPart(frame,WB_TEXT+1,4)<>sum refuse "the check sum is "+sum;
        split StrPart(frame,1,WB_TEXT);
        heard_number:=heard_number MOD 9999+1;
        IF NOT StrToVal(word{1},number) refuse "no number";
        IF number<>heard_number refuse "not the next number";
        after:=state_after(word{2});
        IF after="" refuse "not in order when "+state;
        IF trouble="" handle;
        IF trouble<>"" RETURN;
        ClkStop since_heard;
        ClkReset since_heard;
        ClkStart since_heard;
        state:=after;
        IF word{2}="end" OR word{2}="run" OR word{2}="hello" OR word{2}="abort" RETURN;
        add_to_all StrPart(frame,1,WB_TEXT);
    ENDPROC

    FUNC string state_after(string event)
        VAR string row;

        FOR k FROM 1 TO WB_ROWS DO
            row:=state+" "+event+" ";
            IF StrLen(wb_row{k})>StrLen(row) THEN
                IF StrPart(wb_row{k},1,StrLen(row))=row RETURN StrPart(wb_row{k},StrLen(row)+1,StrLen(wb_row{k})-StrLen(row));
            ENDIF
        ENDFOR
        RETURN "";
    ENDFUNC

    PROC handle()
        VAR string sum;

        sum:=ByteToStr(sum_high\Hex)+ByteToStr(sum_low\Hex);
        TEST word{2}
        CASE "hello":
            IF word{3}<>WB_VERSION THEN
                refuse "the version here is "+WB_VERSION;
            ELSE
                say "hello "+WB_VERSION+" "+WB_ARMS;
            ENDIF
            RETURN;
        CASE "plan":
            begin_program;
        CASE "ticket":
            take_ticket;
        CASE "start":
            take_start;
        CASE "load":
            take_load;
        CASE "axes":
            take_axes;
        CASE "leg":
            take_leg;
        CASE "to":
            take_point;
        CASE "end":
            end_program;
        CASE "run":
            check_run;
        CASE "next":
            let_step;
        CASE "ping":
            ! Nothing but the acknowledgement below.
        CASE "abort":
            StopMove\Quick\AllMotionTasks;
            say "stopped";
            RETURN;
        DEFAULT:
            refuse "this means nothing";
        ENDTEST
        IF trouble="" say "ok "+digits(heard_number,4)+" "+sum;
        IF word{2}="run" AND trouble="" THEN
            wb_kind:=WB_PROGRAM;
            wb_order:=wb_order+1;
        ENDIF
    ENDPROC

    PROC begin_program()
        IF words<>3 OR StrLen(word{3})<>64 THEN
            refuse "no digest of a plan";
            RETURN;
        ENDIF
        all_high:=WB_FIRST_BYTE;
        all_low:=WB_FIRST_BYTE;
        wb_steps:=0;
        started:=0;
        load_arm:=0;
        open_points:=0;
        ticket:="";
        FOR arm FROM 1 TO 2 DO
            wb_legs{arm}:=0;
            wb_points{arm}:=0;
            wb_step{arm}:=0;
            wb_asks{arm}:=0;
            wb_at{arm}:=0;
            wb_part{arm}:=WB_UNTOLD;
            wb_has_load{arm,WB_OF_TOOL}:=FALSE;
            wb_has_load{arm,WB_OF_PART}:=FALSE;
            part_told{arm}:=FALSE;
        ENDFOR
    ENDPROC

    PROC take_ticket()
        IF words<5 OR words>6 OR StrLen(word{3})<>16 OR ticket<>"" THEN
            refuse "no ticket, or a second one";
            RETURN;
        ENDIF
        is_stepped:=words=6;
        IF is_stepped AND word{6}<>"stepped" refuse "no manner in which a program is run";
        ticket:=word{3};
        IF NOT (StrToVal(word{4},told_legs) AND StrToVal(word{5},told_points)) refuse "no counts";
    ENDPROC

    PROC take_start()
        VAR num arm;

        arm:=arm_of(word{3});
        IF words<>10 OR arm=0 OR ticket="" THEN
            refuse "no start of an arm";
            RETURN;
        ENDIF
        IF wb_points{arm}<>0 THEN
            refuse "a second start";
            RETURN;
        ENDIF
        wb_point{arm,1}:=target_of(4);
        wb_seconds{arm,1}:=0;
        wb_points{arm}:=1;
        started:=started+1;
    ENDPROC

    ! Mass and centre of gravity; the axes of the same load come next.
    PROC take_load()
        VAR num number{4};

        IF words<>8 OR arm_of(word{3})=0 OR load_named(word{4})=0 OR started<>2 OR wb_steps<>0 OR load_arm<>0 THEN
            refuse "a load at the wrong place";
            RETURN;
        ENDIF
        load_arm:=arm_of(word{3});
        load_of:=load_named(word{4});
        FOR k FROM 1 TO 4 DO
            IF NOT StrToVal(word{k+4},number{k}) refuse "no number";
        ENDFOR
        IF wb_has_load{load_arm,load_of} refuse "a second load";
        IF number{1}<=0 OR (number{2}=0 AND number{3}=0 AND number{4}=0) refuse "a load without mass or centre";
        wb_load{load_arm,load_of}.mass:=number{1};
        wb_load{load_arm,load_of}.cog:=[number{2},number{3},number{4}];
    ENDPROC

    PROC take_axes()
        VAR num number{7};

        IF words<>11 OR load_arm=0 OR load_arm<>arm_of(word{3}) OR load_of<>load_named(word{4}) THEN
            refuse "axes without their load";
            RETURN;
        ENDIF
        FOR k FROM 1 TO 7 DO
            IF NOT StrToVal(word{k+4},number{k}) refuse "no number";
        ENDFOR
        IF Abs(number{1}*number{1}+number{2}*number{2}+number{3}*number{3}+number{4}*number{4}-1)>0.002 refuse "no orientation";
        IF number{5}<0 OR number{6}<0 OR number{7}<0 refuse "an inertia below 0";
        wb_load{load_arm,load_of}.aom:=[number{1},number{2},number{3},number{4}];
        wb_load{load_arm,load_of}.ix:=number{5};
        wb_load{load_arm,load_of}.iy:=number{6};
        wb_load{load_arm,load_of}.iz:=number{7};
        wb_has_load{load_arm,load_of}:=TRUE;
        load_arm:=0;
    ENDPROC

    FUNC num load_named(string text)
        IF text="tool" RETURN WB_OF_TOOL;
        IF text="part" RETURN WB_OF_PART;
        RETURN 0;
    ENDFUNC

    PROC take_leg()
        VAR num arm;
        VAR num leg;
        VAR num nr;
        VAR num count;
        VAR num zone;
        VAR num opening;

        arm:=arm_of(word{4});
        IF words<>10 OR arm=0 OR started<>2 OR open_points<>0 OR load_arm<>0 THEN
            refuse "a leg at the wrong place";
            RETURN;
        ENDIF
        IF NOT (StrToVal(word{3},nr) AND StrToVal(word{6},count) AND StrToVal(word{7},zone) AND StrToVal(word{9},opening)) THEN
            refuse "a leg without its numbers";
            RETURN;
        ENDIF
        leg:=wb_legs{arm}+1;
        IF leg>WB_MOST_LEGS OR wb_points{arm}+count>WB_MOST_POINTS OR count<1 THEN
            refuse "too many legs or points";
            RETURN;
        ENDIF
        IF nr<>wb_steps+1 AND (nr<>wb_steps OR word{10}="alone") THEN
            refuse "not the next step";
            RETURN;
        ENDIF
        IF leg>1 THEN
            IF wb_leg_step{arm,leg-1}=nr THEN
                refuse "an arm moves twice in a step";
                RETURN;
            ENDIF
        ENDIF
        wb_steps:=nr;
        wb_legs{arm}:=leg;
        wb_leg_step{arm,leg}:=nr;
        wb_leg_first{arm,leg}:=wb_points{arm}+1;
        wb_leg_last{arm,leg}:=wb_points{arm}+count;
        wb_leg_zone{arm,leg}:=zone;
        wb_leg_opening{arm,leg}:=opening;
        wb_leg_hand{arm,leg}:=hand_of(word{8});
        wb_leg_mode{arm,leg}:=mode_of(word{10});
        open_arm:=arm;
        open_points:=count;
    ENDPROC

    PROC take_point()
        VAR num index;
        VAR num milliseconds;
        VAR num k;

        IF words<>11 OR open_points=0 THEN
            refuse "a point without its leg";
            RETURN;
        ENDIF
        IF NOT (StrToVal(word{3},index) AND StrToVal(word{11},milliseconds)) THEN
            refuse "a point without its numbers";
            RETURN;
        ENDIF
        k:=wb_points{open_arm}+1;
        IF index<>k-wb_leg_first{open_arm,wb_legs{open_arm}}+1 OR milliseconds<1 THEN
            refuse "not the next point";
            RETURN;
        ENDIF
        wb_point{open_arm,k}:=target_of(4);
        wb_seconds{open_arm,k}:=milliseconds/1000;
        wb_points{open_arm}:=k;
        open_points:=open_points-1;
    ENDPROC

    PROC end_program()
        VAR num count;

        IF words<>4 OR open_points<>0 THEN
            refuse "the last leg is not whole";
            RETURN;
        ENDIF
        IF NOT StrToVal(word{3},count) refuse "no count";
        IF count<>told_points OR count<>wb_points{1}+wb_points{2}-2 refuse "points are missing";
        IF told_legs<>wb_legs{1}+wb_legs{2} refuse "legs are missing";
        IF word{4}<>ByteToStr(all_high\Hex)+ByteToStr(all_low\Hex) refuse "the sum of all differs";
        IF wb_steps=0 refuse "no steps";
        IF trouble="" check_steps;
    ENDPROC

    ! Alone moves one arm; free and sync move both, sync at the same times.
    PROC check_steps()
        VAR num right;
        VAR num left;

        FOR nr FROM 1 TO wb_steps DO
            right:=leg_in(WB_RIGHT,nr);
            left:=leg_in(WB_LEFT,nr);
            IF right>0 AND left>0 THEN
                IF wb_leg_mode{1,right}<>wb_leg_mode{2,left} OR wb_leg_mode{1,right}=WB_ALONE refuse "modes differ";
                IF wb_leg_mode{1,right}=WB_SYNC check_times right,left;
            ELSEIF right>0 THEN
                IF wb_leg_mode{1,right}<>WB_ALONE refuse "one arm alone";
            ELSEIF left>0 THEN
                IF wb_leg_mode{2,left}<>WB_ALONE refuse "one arm alone";
            ELSE
                refuse "a step without legs";
            ENDIF
        ENDFOR
    ENDPROC

    PROC check_times(num right,num left)
        VAR num count;
        VAR num k;
        VAR num j;

        count:=wb_leg_last{1,right}-wb_leg_first{1,right};
        IF count<>wb_leg_last{2,left}-wb_leg_first{2,left} THEN
            refuse "sync legs differ in length";
            RETURN;
        ENDIF
        FOR i FROM 0 TO count DO
            k:=wb_leg_first{1,right}+i;
            j:=wb_leg_first{2,left}+i;
            IF wb_seconds{1,k}<>wb_seconds{2,j} refuse "sync legs differ in time";
        ENDFOR
    ENDPROC

    ! FOR counts down when the end is less than the beginning.
    FUNC num leg_in(num arm,num nr)
        IF wb_legs{arm}=0 RETURN 0;
        FOR leg FROM 1 TO wb_legs{arm} DO
            IF wb_leg_step{arm,leg}=nr RETURN leg;
        ENDFOR
        RETURN 0;
    ENDFUNC

    PROC check_run()
        IF word{3}<>ticket refuse "another ticket was loaded";
        FOR k FROM 1 TO 16 DO
            IF wb_ticket{k}=ticket refuse "this ticket was run before";
        ENDFOR
        FOR arm FROM 1 TO 2 DO
            IF NOT stands_at_start(arm) refuse "an arm is not at its start";
        ENDFOR
        IF fault_of_arms()<>"" refuse fault_of_arms();
        IF NOT (wb_ready{1} AND wb_ready{2}) refuse "an arm is still on its way home";
        IF wb_ended{1}<>wb_order OR wb_ended{2}<>wb_order refuse "an arm is still busy";
        IF trouble<>"" RETURN;
        wb_let:=wb_steps;
        IF is_stepped wb_let:=0;
        wb_tickets:=wb_tickets+1;
        IF wb_tickets>16 wb_tickets:=1;
        wb_ticket{wb_tickets}:=ticket;
    ENDPROC

    ! One word lets one step run: that which both arms have come to.
    PROC let_step()
        VAR num nr;

        IF words<>3 OR StrLen(word{3})<>2 OR NOT StrToVal(word{3},nr) THEN
            refuse "no number of a step";
            RETURN;
        ENDIF
        IF nr<>wb_let+1 THEN
            refuse "another step waits";
            RETURN;
        ENDIF
        wb_let:=nr;
    ENDPROC

    FUNC bool stands_at_start(num arm)
        VAR jointtarget here;
        VAR jointtarget there;

        here:=CJointT(\TaskName:=wb_both{arm}.taskname);
        there:=wb_point{arm,1};
        IF Abs(here.robax.rax_1-there.robax.rax_1)>WB_START_TOLERANCE RETURN FALSE;
        IF Abs(here.robax.rax_2-there.robax.rax_2)>WB_START_TOLERANCE RETURN FALSE;
        IF Abs(here.robax.rax_3-there.robax.rax_3)>WB_START_TOLERANCE RETURN FALSE;
        IF Abs(here.robax.rax_4-there.robax.rax_4)>WB_START_TOLERANCE RETURN FALSE;
        IF Abs(here.robax.rax_5-there.robax.rax_5)>WB_START_TOLERANCE RETURN FALSE;
        IF Abs(here.robax.rax_6-there.robax.rax_6)>WB_START_TOLERANCE RETURN FALSE;
        RETURN Abs(here.extax.eax_a-there.extax.eax_a)<=WB_START_TOLERANCE;
    ENDFUNC

    ! While a program runs: parts, faults, silence of the workbench, the end.
    PROC watch_arms()
        VAR string fault;

        FOR arm FROM 1 TO 2 DO
            IF wb_part{arm}<>WB_UNTOLD AND NOT part_told{arm} tell_part arm;
        ENDFOR
        fault:=fault_of_arms();
        IF fault="" AND ClkRead(since_heard)>WB_SILENCE fault:="the client was silent while the robot moved";
        IF fault<>"" THEN
            StopMove\Quick\AllMotionTasks;
            state:=state_after("fault");
            say "fault "+fault;
            TPWrite "Workbench: "+fault;
        ELSEIF wb_ended{1}=wb_order AND wb_ended{2}=wb_order THEN
            state:=state_after("done");
            say "done "+digits(wb_steps,2);
        ELSEIF state="running" AND wb_asks{1}=wb_let+1 AND wb_asks{2}=wb_let+1 THEN
            state:=state_after("wait");
        ENDIF
    ENDPROC

    PROC tell_part(num arm)
        VAR string text;

        part_told{arm}:=TRUE;
        text:="part "+letter_of(arm);
        IF wb_part{arm}=WB_PICKED THEN
            say text+" picked";
        ELSE
            IF wb_part{arm}=WB_MISSED THEN
                text:=text+" missed";
            ELSE
                text:=text+" failed";
            ENDIF
            text:=text+" closed to "+NumToStr(wb_width{arm},1);
            say text+" mm where "+NumToStr(wb_expected{arm},1)+" mm were expected";
        ENDIF
    ENDPROC

    ! The system outputs that the README of this folder sets up.
    FUNC string fault_of_arms()
        IF DOutput(doWbEmergency)=1 RETURN "emergency stop";
        IF DOutput(doWbRightRuns)=0 RETURN "the program pointer of an arm is lost";
        IF DOutput(doWbLeftRuns)=0 RETURN "the program pointer of an arm is lost";
        RETURN "";
    ENDFUNC

    PROC report()
        VAR num nr;

        ClkStop since_report;
        ClkReset since_report;
        ClkStart since_report;
        nr:=wb_step{1};
        IF wb_step{2}<nr nr:=wb_step{2};
        IF state="waiting" THEN
            say "state waiting "+digits(wb_let+1,2)+" R00 L00";
        ELSEIF state<>"running" THEN
            say "state "+state+" 00 R00 L00";
        ELSE
            say "state "+state+" "+digits(nr,2)+" R"+digits(point_in(1,nr),2)+" L"+digits(point_in(2,nr),2);
        ENDIF
        FOR arm FROM 1 TO 2 DO
            say "at "+letter_of(arm)+joints_of(CJointT(\TaskName:=wb_both{arm}.taskname));
        ENDFOR
    ENDPROC

    FUNC num point_in(num arm,num nr)
        IF wb_step{arm}<>nr RETURN 0;
        RETURN wb_at{arm};
    ENDFUNC

    ! ---- abb-socket --------------------------------------------------------

    PROC serve_requests(string first)
        VAR string text;
        VAR string kind;
        VAR num arm;
        VAR num active;
        VAR num hand;
        VAR bool has_come_in;
        VAR bool has_closed;

        ! What is refused is said in abb-socket/2 alone.
        state:="";
        text:=first;
        active:=0;
        hand:=WB_KEEP;
        has_come_in:=FALSE;
        has_closed:=FALSE;
        WHILE is_connected AND trouble="" DO
            text:=whole_request(text);
            IF trouble<>"" OR NOT is_connected RETURN;
            IF StrFind(text,1,"#")<3 THEN
                trouble:="no message";
                RETURN;
            ENDIF
            kind:=StrPart(text,1,StrFind(text,1,"#")-2);
            arm:=arm_of(StrPart(text,StrLen(kind)+1,1));
            IF arm=0 OR (kind<>"start" AND arm<>active) OR (kind="start" AND active<>0) THEN
                trouble:="out of order: "+kind;
                RETURN;
            ENDIF
            TEST kind
            CASE "start":
                active:=arm;
                hand:=WB_OPEN;
                has_come_in:=FALSE;
                has_closed:=FALSE;
            CASE "in":
                order arm,text,hand;
                has_come_in:=TRUE;
                hand:=WB_KEEP;
            CASE "out":
                hand:=WB_KEEP;
                IF has_come_in hand:=WB_GRIP;
                order arm,text,hand;
                has_closed:=has_closed OR has_come_in;
                has_come_in:=FALSE;
            CASE "stop":
                IF has_closed order arm,"",WB_OPEN;
                active:=0;
            DEFAULT:
                trouble:="no message: "+kind;
                RETURN;
            ENDTEST
            IF trouble="" say_plain "send";
            text:="";
        ENDWHILE
    ENDPROC

    ! A message is whole with its #, or with the star after the seventh number.
    FUNC string whole_request(string begun)
        VAR string text;
        VAR string piece;

        text:=begun;
        WHILE is_connected AND NOT is_whole(text) DO
            piece:=received(1,WAIT_MAX);
            IF StrLen(text)+1>WB_FRAME THEN
                trouble:="a message is too long";
                RETURN text;
            ENDIF
            text:=text+piece;
        ENDWHILE
        RETURN text;
    ENDFUNC

    FUNC bool is_whole(string text)
        VAR num mark;
        VAR num stars;

        mark:=StrFind(text,1,"#");
        IF mark>StrLen(text) RETURN FALSE;
        IF StrFind(text,1,"s")=1 RETURN TRUE;
        stars:=0;
        FOR k FROM 1 TO StrLen(text) DO
            IF StrPart(text,k,1)="*" stars:=stars+1;
        ENDFOR
        RETURN stars=8;
    ENDFUNC

    ! Gives one motion to an arm and waits until it is done.
    PROC order(num arm,string text,num hand)
        IF NOT (wb_ready{1} AND wb_ready{2}) THEN
            trouble:="an arm is still on its way home";
            RETURN;
        ENDIF
        wb_mover:=arm;
        wb_hand:=hand;
        wb_moves:=text<>"";
        IF wb_moves THEN
            split_stars text;
            wb_target:=target_of(1);
        ENDIF
        IF trouble<>"" RETURN;
        wb_kind:=WB_SINGLE;
        wb_order:=wb_order+1;
        WHILE wb_ended{1}<>wb_order OR wb_ended{2}<>wb_order DO
            WaitTime 0.01;
            IF fault_of_arms()<>"" THEN
                trouble:=fault_of_arms();
                RETURN;
            ENDIF
            IF has_left() THEN
                trouble:="the client left, or spoke, while an arm moved";
                RETURN;
            ENDIF
        ENDWHILE
    ENDPROC

    ! Nothing may come while an arm moves.  Peeking is not asked: whether it tells
    ! of a client that has left is not written down, of receiving it is.
    FUNC bool has_left()
        VAR string piece;

        SocketReceive client\Str:=piece\ReadNoOfBytes:=1\Time:=0.01;
        RETURN TRUE;
    ERROR
        IF ERRNO=ERR_SOCK_TIMEOUT RETURN FALSE;
        is_connected:=FALSE;
        RETURN TRUE;
    ENDFUNC

    ! ---- words and numbers -------------------------------------------------

    PROC split(string text)
        VAR num k;
        VAR num from_here;

        words:=0;
        FOR n FROM 1 TO 12 DO
            word{n}:="";
        ENDFOR
        k:=1;
        WHILE k<=StrLen(text) AND words<12 DO
            from_here:=StrFind(text,k," "\NotInSet);
            IF from_here>StrLen(text) RETURN;
            k:=StrFind(text,from_here," ");
            words:=words+1;
            word{words}:=StrPart(text,from_here,k-from_here);
        ENDWHILE
    ENDPROC

    PROC split_stars(string text)
        VAR num k;
        VAR num next;

        k:=StrFind(text,1,"*");
        FOR n FROM 1 TO 7 DO
            IF k>=StrLen(text) THEN
                trouble:="numbers are missing";
                RETURN;
            ENDIF
            next:=StrFind(text,k+1,"*");
            word{n}:=StrPart(text,k+1,next-k-1);
            k:=next;
        ENDFOR
    ENDPROC

    ! Seven words from one on; the seventh axis is an external one in RAPID.
    FUNC jointtarget target_of(num first)
        VAR jointtarget target;
        VAR num q{7};

        FOR k FROM 1 TO 7 DO
            IF NOT StrToVal(word{first+k-1},q{k}) refuse "no number";
        ENDFOR
        target.robax:=[q{1},q{2},q{3},q{4},q{5},q{6}];
        target.extax:=[q{7},9E9,9E9,9E9,9E9,9E9];
        RETURN target;
    ENDFUNC

    FUNC string joints_of(jointtarget here)
        VAR string text;

        text:=" "+two(here.robax.rax_1)+" "+two(here.robax.rax_2)+" "+two(here.robax.rax_3);
        text:=text+" "+two(here.robax.rax_4)+" "+two(here.robax.rax_5)+" "+two(here.robax.rax_6);
        RETURN text+" "+two(here.extax.eax_a);
    ENDFUNC

    FUNC string two(num value)
        RETURN NumToStr(value,2);
    ENDFUNC

    FUNC string digits(num value,num count)
        VAR string text;

        text:=NumToStr(value,0);
        WHILE StrLen(text)<count DO
            text:="0"+text;
        ENDWHILE
        RETURN text;
    ENDFUNC

    FUNC num arm_of(string letter)
        IF letter="R" RETURN WB_RIGHT;
        IF letter="L" RETURN WB_LEFT;
        RETURN 0;
    ENDFUNC

    FUNC string letter_of(num arm)
        IF arm=WB_RIGHT RETURN "R";
        RETURN "L";
    ENDFUNC

    FUNC num hand_of(string text)
        TEST text
        CASE "open":
            RETURN WB_OPEN;
        CASE "grip":
            RETURN WB_GRIP;
        CASE "keep":
            RETURN WB_KEEP;
        DEFAULT:
            refuse "no such hand";
            RETURN WB_KEEP;
        ENDTEST
    ENDFUNC

    FUNC num mode_of(string text)
        TEST text
        CASE "alone":
            RETURN WB_ALONE;
        CASE "free":
            RETURN WB_FREE;
        CASE "sync":
            RETURN WB_SYNC;
        DEFAULT:
            refuse "no such mode";
            RETURN WB_ALONE;
        ENDTEST
    ENDFUNC

    ! ---- the sum: CRC-16, polynomial 1021, a table for each byte -----------

    PROC fill_tables()
        VAR byte high;
        VAR byte low;
        VAR bool carry;

        FOR value FROM 0 TO 255 DO
            high:=value;
            low:=0;
            FOR bit FROM 1 TO 8 DO
                carry:=high>=128;
                high:=(high*2) MOD 256;
                IF low>=128 high:=high+1;
                low:=(low*2) MOD 256;
                IF carry THEN
                    high:=BitXOr(high,16);
                    low:=BitXOr(low,33);
                ENDIF
            ENDFOR
            table_high{value+1}:=high;
            table_low{value+1}:=low;
        ENDFOR
    ENDPROC

    PROC add_to_sum(string text)
        VAR num index;

        FOR k FROM 1 TO StrLen(text) DO
            index:=BitXOr(sum_high,StrToByte(StrPart(text,k,1)\Char))+1;
            sum_high:=BitXOr(sum_low,table_high{index});
            sum_low:=table_low{index};
        ENDFOR
    ENDPROC

    PROC add_to_all(string text)
        VAR num index;

        FOR k FROM 1 TO StrLen(text) DO
            index:=BitXOr(all_high,StrToByte(StrPart(text,k,1)\Char))+1;
            all_high:=BitXOr(all_low,table_high{index});
            all_low:=table_low{index};
        ENDFOR
    ENDPROC

    ! ---- the socket --------------------------------------------------------

    PROC say(string text)
        VAR string body;

        said_number:=said_number MOD 9999+1;
        body:=digits(said_number,4)+" "+text;
        IF StrLen(body)>WB_TEXT body:=StrPart(body,1,WB_TEXT);
        WHILE StrLen(body)<WB_TEXT DO
            body:=body+" ";
        ENDWHILE
        sum_high:=WB_FIRST_BYTE;
        sum_low:=WB_FIRST_BYTE;
        add_to_sum body;
        say_plain body+ByteToStr(sum_high\Hex)+ByteToStr(sum_low\Hex)+"\0A";
    ENDPROC

    PROC say_plain(string text)
        IF is_connected SocketSend client\Str:=text;
    ERROR
        is_connected:=FALSE;
        RETURN;
    ENDPROC

    ! The first reason counts; the link is closed after it.  A reason has no word of the
    ! client's in it: a string has 80 characters, and more is an error.
    PROC refuse(string why)
        IF trouble<>"" RETURN;
        trouble:=why;
        IF state<>"" say "no "+digits(heard_number,4)+" "+why;
    ENDPROC

    FUNC string received(num count,num seconds)
        VAR string text;
        VAR string piece;

        text:="";
        WHILE StrLen(text)<count DO
            SocketReceive client\Str:=piece\ReadNoOfBytes:=count-StrLen(text)\Time:=seconds;
            text:=text+piece;
        ENDWHILE
        RETURN text;
    ERROR
        is_connected:=FALSE;
        RETURN "";
    ENDFUNC
ENDMODULE
